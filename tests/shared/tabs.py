"""Tabs of the app in a browser, with their errors and requests."""

import re

from served import PATIENCE

DESKTOP = {"width": 1280, "height": 900}


class Tabs:
    """Tabs of the app, with the errors they report and the addresses they ask."""

    def __init__(self, server, browser):
        self.server, self.browser = server, browser
        self.contexts, self.problems, self.asked = [], [], []

    def open(self, query="", **options):
        # a run that plays on takes a core of its own where no graphics card draws: only for who asks, see PLAYING
        context = self.browser.new_context(**{"viewport": DESKTOP, "reduced_motion": "reduce"} | options)
        self.contexts.append(context)
        context.set_default_timeout(PATIENCE)
        # as for a visitor who used the tools last, with all of them in sight; ?view=hero shows the page as it opens
        context.add_init_script("localStorage.getItem('view') ?? localStorage.setItem('view', 'lab')")
        page = context.new_page()
        page.on("console", lambda message: self.problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(self.server.address + query)
        return page

    def close(self):
        for context in self.contexts:
            context.close()

    def check(self):
        """Fail if a tab reported an error or made an external request."""
        assert not self.problems
        own = re.compile(rf"(http|ws)://localhost:{self.server.port}/|data:|blob:")
        assert not [url for url in self.asked if not own.match(url)]
