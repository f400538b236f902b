"""Debian's Firefox with one tab, driven over WebDriver BiDi: Playwright's Firefox is a build of its own."""

import asyncio
import json
import subprocess
import threading

from tornado.websocket import websocket_connect

PREFERENCES = {
    "ui.prefersReducedMotion": 1,  # a run that plays on takes a core where no graphics card draws
    "network.captive-portal-service.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
}


class Firefox:
    """A headless Firefox; `errors`: what its console reports."""

    def __init__(self, path, profile, patience):
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()]
        (profile / "user.js").write_text("\n".join(lines), encoding="utf-8")
        command = [path, "--headless", "--no-remote", "--profile", profile, "--remote-debugging-port", "0"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        self.patience, self.errors, self.answers, self.count = patience, [], {}, 0
        self.loop = asyncio.new_event_loop()
        threading.Thread(target=self.loop.run_forever, daemon=True).start()
        address = next(line.split()[-1] for line in self.process.stderr if "WebDriver BiDi listening" in line)
        threading.Thread(target=self.process.stderr.read, daemon=True).start()  # a full pipe would stop it
        self._run(self._connect(f"{address}/session"))
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self.tab = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def _run(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(self.patience)

    async def _connect(self, address):
        self.socket = await websocket_connect(address)
        self.listener = asyncio.create_task(self._listen())

    async def _listen(self):
        while text := await self.socket.read_message():
            message = json.loads(text)
            if message["type"] == "event":
                if message["params"]["level"] == "error":
                    self.errors.append(message["params"]["text"])
            else:
                self.answers.pop(message["id"]).set_result(message)

    def call(self, method, **parameters):
        """The result of a command of WebDriver BiDi."""

        message = self._run(self._call(method, parameters))
        assert message["type"] == "success", message
        return message["result"]

    async def _call(self, method, parameters):
        self.count += 1
        answer = self.answers[self.count] = self.loop.create_future()
        await self.socket.write_message(json.dumps({"id": self.count, "method": method, "params": parameters}))
        return await answer

    def open(self, address):
        self.call("browsingContext.navigate", context=self.tab, url=address, wait="interactive")

    def evaluate(self, expression):
        """The value of an expression, which may be a promise, by way of JSON."""
        text = f"Promise.resolve({expression}).then(JSON.stringify)"
        target = {"context": self.tab}
        result = self.call("script.evaluate", expression=text, target=target, awaitPromise=True)
        assert result["type"] == "success", result["exceptionDetails"]["text"]
        return json.loads(result["result"].get("value", "null"))

    def wait_for(self, condition):
        self.evaluate(f"""new Promise((then) => {{
            const look = () => ({condition} ? then(true) : setTimeout(look, 50))
            look()
        }})""")

    def drag(self, start, end):
        """With the mouse, from one point of the page to another."""
        move = [{"type": "pointerMove", "x": round(x), "y": round(y)} for x, y in (start, end)]
        button = [{"type": f"pointer{way}", "button": 0} for way in ("Down", "Up")]
        mouse = {"type": "pointer", "id": "mouse", "actions": [move[0], button[0], move[1], button[1]]}
        self.call("input.performActions", context=self.tab, actions=[mouse])

    def close(self):
        self.process.terminate()
        self.process.wait(self.patience)
        self.loop.call_soon_threadsafe(self.loop.stop)
