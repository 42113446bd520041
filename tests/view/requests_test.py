"""The viewer's requests: what it answers, and to whom."""

import http.client
import json
import pathlib
import socket
import subprocess
import unittest
import urllib.error
import urllib.parse
import urllib.request

from viewer import Viewer, tool


class Requests(unittest.TestCase):
    def setUp(self):
        self.viewer = self.enterContext(Viewer())
        parts = urllib.parse.urlsplit(self.viewer.address)
        self.port = parts.port
        self.root = parts.path

    def ask(self, path, body=None, method=None, **headers):
        """Status, headers and bytes of the answer."""
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.port}{path}",
            data=None if body is None else json.dumps(body).encode(),
            headers={k.replace("_", "-"): v for k, v in headers.items()},
            method=method,
        )
        try:
            with urllib.request.urlopen(request) as answer:
                return answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as answer:
            with answer:
                return answer.code, answer.headers, answer.read()

    def json(self, path, body=None):
        status, _, content = self.ask(self.root + path, body)
        return status, json.loads(content)

    def finished(self, change=1):
        state = {"number": 0, "finished": False, "change": 0}
        while not (state["finished"] and state["change"] >= change):
            _, state = self.json(f"state?after={state['number']}")
        return state

    def test_only_who_knows_the_token_is_told_anything(self):
        for path in ("/", "/scene", "/0123/", self.root[:-1], "/" + "0" * 32 + "/scene"):
            status, _, content = self.ask(path)
            self.assertEqual((status, content), (404, b""), path)
        self.assertEqual(self.ask(self.root)[0], 200)
        self.assertEqual(len(self.root), 34)

    def test_other_hosts_and_other_pages_are_refused(self):
        self.assertEqual(self.ask(self.root + "scene", Host="evil.example")[0], 404)
        self.assertEqual(self.ask(self.root + "scene", Host="127.0.0.1:1")[0], 404)
        self.assertEqual(self.ask(self.root + "scene", Origin="http://evil.example")[0], 404)
        own = f"http://127.0.0.1:{self.port}"
        self.assertEqual(self.ask(self.root + "scene", Origin=own)[0], 200)
        self.assertEqual(self.ask(self.root + "scene", Host=f"localhost:{self.port}")[0], 200)

    def test_it_listens_on_this_machine_alone(self):
        try:
            other = socket.gethostbyname(socket.gethostname())
        except OSError:
            other = "127.0.0.1"
        if other.startswith("127."):
            self.skipTest("the machine has no other address that it knows of")
        with self.assertRaises(OSError):
            socket.create_connection((other, self.port), timeout=5)

    def test_the_page_loads_nothing_from_elsewhere(self):
        _, headers, page = self.ask(self.root)
        self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
        for name in ("style.css", "view.js", "controls.js", "camera.js"):
            status, _, text = self.ask(self.root + name)
            self.assertEqual(status, 200)
            self.assertNotIn(b"https://", text)
        self.assertNotIn(b"https://", page)

    def test_pictures_are_those_of_the_renderer(self):
        self.finished()
        tone_maps = self.json("scene")[1]["tone_maps"]
        self.assertEqual(tone_maps[:3], ["srgb", "neutral", "filmic"])
        for tone_map in ("filmic", tone_maps[-1]):  # of ours, and of an OCIO configuration
            query = urllib.parse.urlencode({"exposure": 1, "tone_map": tone_map})
            _, headers, shown = self.ask(self.root + "picture?" + query)
            self.assertEqual((headers["X-Width"], headers["X-Height"]), ("160", "90"))
            png = self.viewer.folder / "a.png"
            subprocess.run(
                [tool("pvol-render"), self.viewer.folder / "scene.toml", "-o", png, "--quiet"]
                + ["--exposure", "1", "--tone-map", tone_map],
                check=True,
            )
            subprocess.run(["oiiotool", png, "-o", png.with_suffix(".ppm")], check=True)
            self.assertEqual(png.with_suffix(".ppm").read_bytes()[-len(shown):], shown)
        status, _, refusal = self.ask(self.root + "picture?tone_map=none")
        self.assertEqual(status, 400)
        self.assertIn(b"expected srgb", refusal)

    def test_edits_change_the_picture_and_wrong_ones_do_not(self):
        self.finished()
        before = self.ask(self.root + "picture")[2]
        edit = {"section": "volume[1].medium", "key": "albedo", "value": 0.1}
        status, scene = self.json("scene", {"edits": [edit], "gesture": 1})
        self.assertEqual((status, scene["undo"]), (200, True))
        self.finished(2)
        self.assertNotEqual(self.ask(self.root + "picture")[2], before)
        edit["value"] = 1.5
        status, answer = self.json("scene", {"edits": [edit]})
        self.assertEqual(status, 400)
        self.assertEqual(answer["error"], "albedo: found 1.5, expected a number in [0, 1]")
        self.json("scene", {"undo": True})
        self.finished(3)
        self.assertEqual(self.ask(self.root + "picture")[2], before)

    def test_what_is_no_request_is_refused(self):
        for body in (b"", b"{", b"[]", b"{\"edits\": 5}", b"{\"edits\": [{}]}", b"\xff\xfe", b"{\"edits\": []}",
                     b"{\"edits\": {}}", b"{\"frame\": true}", b"{\"show\": {\"layer\": \"depth\", \"filter\": 3}}"):
            request = urllib.request.Request(self.viewer.address + "scene", data=body)
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(request)
            self.assertEqual(refused.exception.code, 400, body)
            refused.exception.close()
        status, scene = self.json("scene")
        self.assertEqual((status, scene["layer"], scene["undo"]), (200, "colour", False))
        for query in ("layer=nonsense", "exposure=bright", "exposure=nan"):
            self.assertEqual(self.ask(self.root + "picture?" + query)[0], 400, query)
        for after in ("1e30", "inf", "nan", "-5"):
            self.assertEqual(self.json("state?after=" + after)[0], 200)

    def test_requests_that_are_too_large_are_refused_in_words(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        self.addCleanup(connection.close)
        connection.putrequest("POST", self.root + "scene")
        connection.putheader("Content-Length", str(2 << 20))
        connection.endheaders()  # it is refused before its body comes
        answer = connection.getresponse()
        self.assertEqual(answer.status, 413)
        self.assertIn("MiB", json.loads(answer.read())["error"])

    def test_an_angle_of_view_replaces_a_focal_length(self):
        def value(scene, key):
            camera = next(s for s in scene["sections"] if s["id"] == "camera")
            return next(k["value"] for k in camera["keys"] if k["key"] == key)

        _, scene = self.json("scene", {"edits": [{"section": "camera", "key": "focal_length", "value": 50}]})
        self.assertEqual(value(scene, "focal_length"), 50)
        _, scene = self.json("scene", {"edits": [{"section": "camera", "key": "fov", "value": 20}]})
        self.assertEqual((value(scene, "fov"), value(scene, "focal_length")), (20, None))

    def test_pictures_come_however_quickly_changes_follow_each_other(self):
        self.finished()
        _, state = self.json("state?after=0")
        pictures, number = 0, state["number"]
        for i in range(60):
            self.json("scene", {"edits": [{"section": "camera", "key": "fov", "value": 30 + i / 10}]})
            _, state = self.json(f"state?after={max(0, number - 1)}")
            pictures += state["number"] > number
            number = state["number"]
        self.assertGreater(pictures, 5)

    def test_files_of_the_scene_are_not_written_over(self):
        before = (self.viewer.folder / "ball.toml").read_text()
        status, answer = self.json("save", {"name": "ball.toml", "replace": True})
        self.assertEqual(status, 400)
        self.assertIn("reads", answer["error"])
        self.assertEqual((self.viewer.folder / "ball.toml").read_text(), before)

    def test_names_of_skies_are_those_of_the_folder(self):
        (self.viewer.folder / "sky.hdr").write_bytes(
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes((128, 64, 32, 129)) * 8)
        edits = [{"section": "environment", "key": "type", "value": "image"},
                 {"section": "environment", "key": "file", "value": "sky.hdr"}]
        status, scene = self.json("scene", {"edits": edits})
        self.assertEqual(status, 200)
        state = self.finished(scene["change"])
        self.assertEqual(state["error"], "")

    def test_saves_in_its_folder(self):
        status, answer = self.json("save", {"name": "new.toml"})
        self.assertEqual((status, pathlib.Path(answer["path"]).name), (200, "new.toml"))
        self.assertTrue((self.viewer.folder / "new.toml").exists())
        status, answer = self.json("save", {"name": "../new.toml"})
        self.assertEqual(status, 400)
        self.assertFalse((self.viewer.folder.parent / "new.toml").exists())

    def test_a_port_that_is_taken_is_an_error(self):
        scene = self.viewer.folder / "scene.toml"
        second = subprocess.run(
            [tool("pvol-view"), scene, "--port", str(self.port)], capture_output=True, text=True
        )
        self.assertEqual(second.returncode, 1)
        self.assertIn(f"port {self.port} cannot be opened", second.stderr)
        self.assertEqual(second.stdout, "")


class CommandLine(unittest.TestCase):
    def refusal(self, *arguments):
        done = subprocess.run([tool("pvol-view"), *map(str, arguments)], capture_output=True, text=True)
        return done.returncode, done.stderr

    def test_wrong_inputs_end_at_once(self):
        code, text = self.refusal("absent.vdb")
        self.assertEqual(code, 1)
        self.assertIn("absent.vdb", text)
        code, text = self.refusal("smoke.####.vdb")
        self.assertEqual(code, 2)
        self.assertIn("--frames", text)
        code, text = self.refusal("cloud.vdb", "--frames", "1-5")
        self.assertEqual(code, 2)
        self.assertIn("####", text)
        self.assertEqual(self.refusal("cloud.vdb", "--folder", "/nowhere")[0], 2)
        self.assertEqual(self.refusal("cloud.vdb", "--port", "70000")[0], 2)
        self.assertEqual(self.refusal("cloud.vdb", "--spp", "0")[0], 2)


if __name__ == "__main__":
    unittest.main()
