"""The stationary Fokker-Planck equation: `method` has the public function and its result."""
