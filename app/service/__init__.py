"""Worker processes, the jobs that they do, and the caches that all visitors share."""
