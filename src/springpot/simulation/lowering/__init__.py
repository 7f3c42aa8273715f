"""From the plan to the kernel's arguments: units are changed here, one function for each kind of part."""
