"""The Gaussian memory closure: `method` has the public function and its result."""
