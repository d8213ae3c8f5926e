"""Files: text and tables read and checked, the columns of tables, whole files written or none."""
