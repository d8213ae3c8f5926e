"""Fish through computed meshes: which pass, how often they try, what a haul retains."""
