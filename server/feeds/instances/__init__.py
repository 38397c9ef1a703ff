"""Published instances as files, so that anyone can check the dispatcher."""
