"""The design nearest to a plan that reaches what is asked of it, by the numbers that may change."""
