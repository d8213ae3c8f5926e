"""What joins the knots of netting: a file a pattern, each of which writes what only it has, in ports."""
