"""Who tests the tester: wrong codes that must be rejected, right ones that must not, and what an answer gives away."""
