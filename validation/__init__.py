"""Cases, tables and scripts that hold the project to closed forms, papers and its own claims."""
