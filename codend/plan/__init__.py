"""What the user said: the tables of a plan, their messages, and changes to them."""
