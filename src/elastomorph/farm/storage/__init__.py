"""The Zarr group of a data set: laid out, written in units, known to be finished."""
