"""The live experiment as a web page: `panel serve app`."""
