"""Tabs of the app in a browser, with their errors and requests."""

import re

from served import PATIENCE

DESKTOP = {"width": 1280, "height": 900}
_free = {}  # options -> contexts that no Tabs uses: their caches of scripts make loading a page a third cheaper


class Tabs:
    """Tabs of the app, with the errors they report and the addresses they ask."""

    def __init__(self, server, browser):
        self.server, self.browser = server, browser
        self.used, self.problems, self.asked = [], [], []

    def open(self, query="", **options):
        # a run that plays on takes a core of its own where no graphics card draws: only for who asks, see PLAYING
        options = {"viewport": DESKTOP, "reduced_motion": "reduce"} | options
        free = _free.setdefault(repr(sorted(options.items())), [])
        context = free.pop() if free else self._new_context(options)
        self.used.append((free, context))
        page = context.new_page()
        page.on("console", lambda message: self.problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(self.server.address + query)
        return page

    def _new_context(self, options):
        context = self.browser.new_context(**options)
        context.set_default_timeout(PATIENCE)
        # as for a visitor who used the tools last, with all of them in sight; ?view=hero shows the page as it opens
        context.add_init_script("localStorage.getItem('view') ?? localStorage.setItem('view', 'lab')")
        return context

    def close(self):
        """Close the tabs, and empty their contexts of all that a page can store."""
        for free, context in self.used:
            storage = context.new_cdp_session(context.pages[0])
            kinds = "cookies,local_storage,indexeddb,service_workers"
            storage.send("Storage.clearDataForOrigin", {"origin": self.server.origin, "storageTypes": kinds})
            context.clear_permissions()
            for page in context.pages:
                page.close()
            free.append(context)

    def check(self):
        """Fail if a tab reported an error or made an external request."""
        assert not self.problems
        own = re.compile(rf"(http|ws)://localhost:{self.server.port}/|data:|blob:")
        assert not [url for url in self.asked if not own.match(url)]
