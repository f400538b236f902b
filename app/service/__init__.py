"""Worker processes, the tasks that they run, and the caches that all visitors share."""
