"""What files of measurements hold, from their content: columns with names, units and a rate, matrices, and what was assumed."""
