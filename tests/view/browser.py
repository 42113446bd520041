"""A headless Chromium that shows a page, for tests."""

import tempfile
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()


class Browser:
    def __init__(self, width=1280, height=800, scale=1, dark=False):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        options = Options()
        options.binary_location = "/usr/bin/chromium"
        for flag in (
            *FLAGS,
            f"--window-size={width},{height}",
            f"--force-device-scale-factor={scale}",
            f"--user-data-dir={self.profile.name}",
            *(["--force-dark-mode"] if dark else []),
        ):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.driver.quit()
        self.profile.cleanup()

    def open(self, address):
        self.driver.get(address)
        self.until("canvas.dataset.number > 0", "a picture")

    def run(self, script, *arguments):
        """A function body in the page, with `canvas` for the picture."""
        return self.driver.execute_script(
            "const canvas = document.getElementById('picture');" + script, *arguments
        )

    def until(self, condition, what, seconds=60):
        """Waits for a condition of the page; so long that no slow machine fails a test."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.run(f"return Boolean({condition})"):
                return
            time.sleep(0.05)
        raise AssertionError(f"there was never {what}: {self.text('error')}")

    def text(self, element):
        return self.run("return document.getElementById(arguments[0]).textContent", element)

    def messages(self):
        """What the page wrote to the console, which should be nothing but refused requests."""
        entries = [entry["message"] for entry in self.driver.get_log("browser")]
        return [e for e in entries if "status of 400" not in e]

    def colours(self):
        """Red, green and blue of the canvas at 16 x 9 places."""
        return self.run(
            """
            const small = new OffscreenCanvas(16, 9).getContext('2d');
            small.imageSmoothingEnabled = false;
            small.drawImage(canvas, 0, 0, 16, 9);
            const data = [...small.getImageData(0, 0, 16, 9).data];
            return Array.from({ length: 144 }, (_, i) => data.slice(4 * i, 4 * i + 3));"""
        )

    def other_colours(self, colours, seconds=60):
        """Waits until the canvas has other ones."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if (now := self.colours()) != colours:
                return now
            time.sleep(0.05)
        raise AssertionError(f"the colours stay: {self.text('error')}")
