"""Booking without JavaScript: plain HTML forms at /basic, for old phones and screen readers of any age."""
