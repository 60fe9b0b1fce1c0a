"""Golden values: reading and comparing them, looking whether they are whole, making them and verifying them."""
