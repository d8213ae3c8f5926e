"""Examples of use, graded A (a first run) to C (one's own law, net, study), each with numbers it asserts."""
