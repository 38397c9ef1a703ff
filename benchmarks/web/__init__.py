"""What people wait for in the pages, measured in a real browser against a real server."""
