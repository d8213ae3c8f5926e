"""How the pull of the trawl goes with its speed: a power below 2, for its mouth closes as it speeds up.

``python -m validation.trawl.pull_against_speed`` tows the half gear of ``gear``, with floats of ``FLOATS_N`` on half
its headline, at 2.5 to 4 knots and prints pull, opening and power: 1.50 between 2.5 and 4 knots, its mouth 12.4 and
9.9 m high after 50 s, 13.1 and 10.1 m after 200 s (``--end``; the power is the same). With floats of 1200 N it is 1.40,
with the 600 N of the shooting 1.33 after 60 s, below what was measured: the less holds the mouth open, the more it
closes. Measured on models of survey bottom trawls (NOAA Alaska Fisheries Science Center, ``trawlmetrics`` 2025, flume
tank; bridle tension): powers of 1.42 to 1.64.
"""

import argparse

import numpy as np

from validation.trawl.gear import KNOT_M_S
from validation.trawl.shooting import followed, shot

KNOTS = (2.5, 3.0, 3.5, 4.0)
FLOATS_N = 2000.0
"""Assumed."""


def pulls(end_s: float, step_s: float = 0.025, merged: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Pull ahead of the whole gear, N, and its opening, m, at every speed."""
    found = []
    for knots in KNOTS:
        table, _, _ = followed(shot(merged, end_s, step_s, speed_m_s=knots * KNOT_M_S, floats_n=FLOATS_N))
        last = table.iloc[-1]
        found.append((2.0 * last["pull_ahead_n"], last["opening_m"]))
        print(f"{knots:g} knots: pull ahead {found[-1][0]:.0f} N, opening {found[-1][1]:.2f} m", flush=True)
    pull, opening = np.array(found).T
    return pull, opening


def main() -> None:
    """Print the power."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--end", type=float, default=600.0)
    pull, _ = pulls(asked.parse_args().end)
    power = np.polyfit(np.log(KNOTS), np.log(pull), 1)[0]
    print(f"pull goes as speed to the power {power:.2f}")


if __name__ == "__main__":
    main()
