"""One call of the workers that a visitor waits for: the newest counts, and what comes late is forgotten."""


class Wanted:
    """What one part of a visitor's page waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        self.session, self.task = session, None

    def ask(self, call, take, **how):
        """Have call = (function, *arguments) made in place of the one before, then `take(result)`, None if it failed.

        how: rank and seconds, as of `Pool.submit`.
        """
        self.forget()
        task = self.task = self.session.pool.submit(*call, owner=id(self.session), **how)
        self.session.when_done(task, lambda done: self._done(done, take))

    def forget(self):
        """Wait for nothing any longer."""
        if self.task is not None:
            self.session.pool.abandon(self.task)
            self.task = None

    def _done(self, task, take):
        if task is self.task:
            self.task = None
            take(None if task.cancelled() or task.exception() else task.result())
