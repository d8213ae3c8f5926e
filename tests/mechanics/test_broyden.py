"""Steps with an old tangent: those of Broyden's method with its matrix built."""

import numpy as np

from codend.mechanics.broyden import MOST_STEPS, correct, keep, no_steps

NODES, BARS, TENSION = 3, 4, 20.0
UNKNOWNS = 3 * NODES + BARS


def problem(seed):
    """A smooth system of equations, a guess of its tangent, and what the weights of the unknowns' norm are made of."""
    rng = np.random.default_rng(seed)
    matrix = np.eye(UNKNOWNS) + 0.15 * rng.normal(size=(UNKNOWNS, UNKNOWNS))
    bend = 0.02 * rng.normal(size=(UNKNOWNS, UNKNOWNS))
    guess = matrix + 0.03 * rng.normal(size=(UNKNOWNS, UNKNOWNS))
    target = rng.normal(size=UNKNOWNS)
    lengths = rng.uniform(2.0, 6.0, BARS)
    return lambda x: matrix @ x + bend @ x**2 - target, guess, lengths


def steps_of_codend(function, guess, lengths, most=MOST_STEPS):
    past, x, steps = no_steps(NODES, BARS), np.zeros(UNKNOWNS), []
    for count in range(most):
        step = np.linalg.solve(guess, -function(x))
        move, change = step[: 3 * NODES].reshape(NODES, 3).copy(), step[3 * NODES :].copy()
        if count == 0:
            keep(past, count, lengths, TENSION, move, change)
        else:
            assert correct(past, count, lengths, TENSION, move, change)
        steps.append(np.concatenate([move.ravel(), change]))
        x = x + steps[-1]
    return steps, np.linalg.norm(function(x))


def steps_with_the_matrix(function, guess, lengths, most=MOST_STEPS):
    weights = np.concatenate([np.ones(3 * NODES), (lengths**2 / TENSION) ** 2])
    matrix, x, steps = guess.copy(), np.zeros(UNKNOWNS), []
    for _ in range(most):
        step = np.linalg.solve(matrix, -function(x))
        matrix = matrix + np.outer(function(x + step), weights * step) / (step @ (weights * step))
        steps.append(step)
        x = x + step
    return steps


def test_steps_are_those_of_broydens_method_with_its_matrix():
    for seed in range(5):
        of_codend, _ = steps_of_codend(*problem(seed), most=8)
        for ours, theirs in zip(of_codend, steps_with_the_matrix(*problem(seed), most=8), strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_a_tangent_wrong_in_two_directions_is_learnt_in_four_steps_where_equations_are_linear():
    """Broyden's method ends after two steps a wrong direction (Gay 1979, theorem 2.2), and takes one more to see it."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        matrix = np.eye(UNKNOWNS) + 0.15 * rng.normal(size=(UNKNOWNS, UNKNOWNS))
        wrong = 0.02 * rng.normal(size=(UNKNOWNS, 2)) @ rng.normal(size=(2, UNKNOWNS))
        target, lengths = rng.normal(size=UNKNOWNS), rng.uniform(2.0, 6.0, BARS)
        _, early = steps_of_codend(lambda x, m=matrix, t=target: m @ x - t, matrix + wrong, lengths, most=3)
        _, left = steps_of_codend(lambda x, m=matrix, t=target: m @ x - t, matrix + wrong, lengths, most=5)
        assert left < 1e-9 < early


def test_a_tangent_that_calls_for_ever_longer_steps_is_given_up():
    past = no_steps(NODES, BARS)
    move, change = np.ones((NODES, 3)), np.zeros(BARS)
    keep(past, 0, np.ones(BARS), TENSION, move, change)
    assert not correct(past, 1, np.ones(BARS), TENSION, 0.95 * move, change)
    assert correct(past, 1, np.ones(BARS), TENSION, -0.95 * move, change)
