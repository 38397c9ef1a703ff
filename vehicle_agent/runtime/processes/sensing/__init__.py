"""Processes that read sensors and record cameras, and the worker that looks at scans."""
