"""Complete machines as scene files, which are examples for users and the yardstick of the tests."""
