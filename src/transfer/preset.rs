//! Transfer functions that work on unknown data: by name, from the histogram.
