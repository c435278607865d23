//! Quantities with units, parsed at the border.
