"""Settings for all tests."""

from hypothesis import settings

# the first example of a test may have kernels to compile or to read from the cache
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")
