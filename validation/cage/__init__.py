"""The papers' cage (Le Bris et al. 1999, section 6): a model of diamond netting under a frame, in a current."""
