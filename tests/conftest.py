"""Settings for all tests."""

import os

# tests run one a core: libraries that share small matrices out among threads as well would wait for each other
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings

# the first example of a test may have kernels to compile or to read from the cache
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")
