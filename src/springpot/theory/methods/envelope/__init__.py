"""The mean-field envelope: `method` has the public function and its result."""
