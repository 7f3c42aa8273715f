"""What files of measurements and models hold, from their content: columns with names, units and a rate, or a matrix."""
