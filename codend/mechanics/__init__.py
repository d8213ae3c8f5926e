"""Compiled residual and tangent of a net under its loads: the one room of kernels.

Kernels see plain arrays, no plan, table or file. What a kernel reads is gathered in two named tuples: ``Structure``
(the net) and ``Loading`` (what acts on it). Kernels take the arrays out of them before a loop: reaching into a tuple
inside one costs more than the arithmetic.
"""
