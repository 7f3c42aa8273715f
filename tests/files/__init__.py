"""Files of measurements as they lie on desks."""
