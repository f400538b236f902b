"""The session of one visitor: the run on screen, the controls, and the messages between server and browser."""
