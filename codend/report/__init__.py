"""A study written down: tables, plots, VTK files and one page to read, each file whole or not there at all."""
