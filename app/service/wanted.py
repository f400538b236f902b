"""One call of the workers that a visitor waits for: the newest counts, and what comes late is forgotten."""

from app.service.tasks import Part


class Wanted:
    """What one part of a visitor's page waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        self.session, self.task = session, None

    def ask(self, call, take, **how):
        """Have call = (function, *arguments) made in place of the one before, then `take(result)`, None if it failed.

        A call that gives a Part goes on from it. how: rank and seconds, as of `Pool.submit`.
        """
        self.forget()
        self._make(call, (), take, how)

    def forget(self):
        """Wait for nothing any longer."""
        if self.task is not None:
            self.session.pool.abandon(self.task)
            self.task = None

    def _make(self, call, kept, take, how):
        task = self.task = self.session.pool.submit(*call, *kept, owner=id(self.session), **how)
        self.session.when_done(task, lambda done: self._done(done, call, take, how))

    def _done(self, task, call, take, how):
        if task is not self.task:
            return
        self.task = None
        result = None if task.cancelled() or task.exception() else task.result()
        if isinstance(result, Part):
            self._make(call, (result.kept,), take, how)
        else:
            take(result)
