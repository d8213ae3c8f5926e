"""The codend: from a plan to a net under the loads of a case, its netting as a membrane, and what is measured in it."""
