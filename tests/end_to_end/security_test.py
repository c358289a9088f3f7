"""DDS Security with real participants: who sees and does what, with identities made by cansync-security."""

import glob
import json
import os
import pwd
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(__file__))
from gateway import CANSYNCD, LONG, Gateway, Place, identities  # noqa: E402

SCRIPT = os.path.join(os.path.dirname(__file__), "..", "..", "tools", "security", "cansync-security")
NOT_REACHABLE = 6


def security(*arguments):
    """cansync-security with these arguments, to its end."""
    return subprocess.run([SCRIPT, *map(str, arguments)], capture_output=True, text=True, timeout=LONG, check=False)


def made(*arguments):
    result = security(*arguments)
    assert result.returncode == 0, result.stderr


class SecuredGateway(Gateway):
    """A daemon with DDS Security; `cansync` is an engineer unless told otherwise."""

    def __init__(self, authority, **options):
        super().__init__(**options)
        self.authority = authority
        with open(self.config, encoding="utf-8") as file:
            text = file.read()
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(text.replace("[dds]\n", f'[dds]\nsecurity = "{authority}/daemon"\n'))
        self.become("engineer")

    def become(self, name):
        """A folder, or the name of one below the authority."""
        super().become(name if name is None or "/" in name else os.path.join(self.authority, name))


class Security(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="cansync_security_")
        cls.ca = identities(cls.folder)
        cls.gateway = SecuredGateway(cls.ca)
        cls.gateway.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.gateway.__exit__()
        shutil.rmtree(cls.folder)

    def setUp(self):
        self.gateway.become("engineer")

    def expect(self, code, *arguments):
        result = self.gateway.run(*arguments)
        self.assertEqual(result.returncode, code, f"{arguments}: {result.stdout}{result.stderr}")
        return result

    def expect_no_right(self, topic, *arguments):
        """Refused at once, naming the topic; and the daemon heard nothing of it."""
        result = self.gateway.run(*arguments)
        self.assertNotEqual(result.returncode, 0, arguments)
        self.assertIn(f"no right to write topic {topic}", result.stderr, arguments)

    def test_without_identity_nothing_is_seen(self):
        self.gateway.become(None)
        result = self.expect(NOT_REACHABLE, "--timeout", 1, "status")
        self.assertIn("no daemon found", result.stderr)
        self.assertEqual(result.stdout, b"")
        self.expect(NOT_REACHABLE, "--timeout", 1, "control", 1, 0x000F)
        # Neither does its knocking disturb those with an identity.
        self.gateway.become("viewer")
        self.expect(0, "status")

    def test_identity_of_another_authority_sees_nothing(self):
        foreign = os.path.join(self.folder, "foreign")
        made("init", foreign)
        made("add", foreign, "engineer", "--role", "engineer")
        self.gateway.become(os.path.join(foreign, "engineer"))
        result = self.expect(NOT_REACHABLE, "--timeout", 1, "status")
        self.assertIn("no daemon found", result.stderr)
        self.assertEqual(result.stdout, b"")

    def test_viewer_reads_and_writes_nothing(self):
        self.gateway.become("viewer")
        status = json.loads(self.expect(0, "status", "--json").stdout)
        self.assertTrue(status["secured"])
        days_left = status["identity_time_left"] / 86400
        self.assertTrue(3600 < days_left <= 3650, days_left)
        self.assertIn(b"winder", self.expect(0, "slaves").stdout)
        self.assertIn("number", json.loads(self.expect(0, "events", "--json").stdout.splitlines()[0]))
        self.expect_no_right("Command", "control", 1, 0x000F)
        self.expect_no_right("Command", "broadcast", "--yes", "--slaves", "all", "--command", 128)
        self.expect_no_right("ReferenceValues", "set", "0=1", "--seconds", 1)
        self.expect_no_right("ParameterRequest", "write", 1, 100, 5)
        self.expect_no_right("ParameterRequest", "read", 1, 100)
        self.expect_no_right("TransferRequest", "upload", 1, 0x100, 4, os.path.join(self.folder, "up"))
        self.expect_no_right("EngineerCommand", "mode", "setup")

    def test_operator_gives_control_words_and_reference_values_and_no_more(self):
        self.gateway.become("operator")
        self.expect(0, "control", 1, 0x000F)
        self.expect(0, "broadcast", "--yes", "--slaves", "all", "--command", 128)
        self.expect(0, "set", "0=1", "--seconds", 0.2)
        self.expect_no_right("ParameterRequest", "write", 1, 100, 5)
        self.expect_no_right("TransferRequest", "upload", 1, 0x100, 4, os.path.join(self.folder, "up"))
        self.expect_no_right("EngineerCommand", "mode", "setup")
        self.expect_no_right("EngineerCommand", "poll", 1, 0)
        self.expect_no_right("EngineerCommand", "map", "references", 1, "0.low")

    def test_engineer_does_everything(self):
        self.expect(0, "control", 1, 0x000F)
        self.expect(0, "write", 1, 1000, 5)
        self.expect(0, "read", 1, 100)
        self.expect(0, "poll", 1, "auto")
        block = os.path.join(self.folder, "block")
        with open(block, "wb") as file:
            file.write(os.urandom(20000))
        self.expect(0, "download", 2, 0x100, block)
        self.expect(0, "upload", 2, 0x100, 20000, block + ".back")
        with open(block, "rb") as one, open(block + ".back", "rb") as other:
            self.assertEqual(one.read(), other.read())
        self.expect(0, "mode", "setup")
        self.expect(0, "mode", "run", "--force")
        self.gateway.wait_active()

    def test_permissions_that_a_viewer_signs_itself_are_not_believed(self):
        # The identity is right, and its own side believes the permissions; the daemon does not.
        forged = os.path.join(self.folder, "forged")
        shutil.copytree(os.path.join(self.ca, "viewer"), forged)
        other = os.path.join(self.folder, "other")
        made("init", other)
        made("add", other, "viewer", "--role", "engineer")
        with open(os.path.join(other, "viewer", "permissions.p7s"), encoding="utf-8") as file:
            rights = file.read()
        wanted = os.path.join(self.folder, "wanted.xml")
        with open(wanted, "w", encoding="utf-8") as file:
            xml = "<?xml" + rights.split("<?xml", 1)[1].split("</dds>")[0] + "</dds>\n"
            file.write(xml.replace("OU=engineer", "OU=viewer").replace("\r", ""))
        for name, source in (("permissions", wanted), ("governance", None)):
            if source is None:
                shutil.copy(os.path.join(other, "governance.p7s"), forged)
                continue
            subprocess.run(
                ["openssl", "smime", "-sign", "-text", "-in", source, "-out", os.path.join(forged, name + ".p7s"),
                 "-signer", os.path.join(other, "permissions_ca.pem"),
                 "-inkey", os.path.join(other, "authority", "permissions_ca.key")],
                check=True, capture_output=True, timeout=LONG)
        shutil.copy(os.path.join(other, "permissions_ca.pem"), forged)
        self.gateway.become(forged)
        before = self.gateway.log_text()
        result = self.expect(NOT_REACHABLE, "--timeout", 1, "control", 1, 0x0123)
        self.assertIn("no", result.stderr)
        self.gateway.become("engineer")
        self.expect(0, "status")
        self.assertNotIn("0x0123", self.gateway.log_text()[len(before):])

    def test_identity_key_cannot_sign_permissions(self):
        # The two authorities are apart: a signature with an identity does not pass.
        forged = os.path.join(self.folder, "selfsigned")
        shutil.copytree(os.path.join(self.ca, "viewer"), forged)
        document = os.path.join(forged, "permissions.xml")
        with open(document, "w", encoding="utf-8") as file:
            file.write("<dds/>")
        subprocess.run(
            ["openssl", "smime", "-sign", "-text", "-in", document, "-out", os.path.join(forged, "permissions.p7s"),
             "-signer", os.path.join(forged, "certificate.pem"), "-inkey", os.path.join(forged, "key.pem")],
            check=True, capture_output=True, timeout=LONG)
        self.gateway.become(forged)
        result = self.expect(NOT_REACHABLE, "status")
        self.assertIn("permissions.p7s: is not signed by permissions_ca.pem", result.stderr)

    def test_who_did_it_is_told_by_the_certificate(self):
        self.gateway.become("operator")
        self.expect(0, "control", 2, 0x0042)
        events = [json.loads(line) for line in self.expect(0, "events", "--json").stdout.splitlines()]
        done = [e for e in events if e.get("action") == "control_word" and e["new_value"] == "0x0042"]
        self.assertEqual(len(done), 1)
        listed = {line.split()[0]: line.split() for line in security("list", self.ca).stdout.splitlines()[1:]}
        self.assertEqual(done[0]["participant"][:12], listed["operator"][3])


class Identity(unittest.TestCase):
    """A daemon whose identity ends soon."""

    def test_a_renewed_one_counts_from_the_restart_on(self):
        ca = identities(self.enterContext(tempfile.TemporaryDirectory(prefix="cansync_security_")))
        made("renew", ca, "daemon", "--days", "20")
        gateway = self.enterContext(SecuredGateway(ca))

        def found():
            lines = gateway.run("doctor", "--json").stdout.splitlines()
            return next(one for one in map(json.loads, lines) if one["topic"] == "identity")

        before = found()
        self.assertEqual(before["level"], "warning", before)
        self.assertIn("cansync-security renew", before["remedy"])
        made("renew", ca, "daemon")
        self.assertEqual(found()["level"], "warning", "what runs has the old one")
        gateway.process.terminate()
        gateway.process.wait(LONG)
        with open(gateway.log, "ab") as log:
            gateway.process = subprocess.Popen([CANSYNCD, gateway.config], stdout=log, stderr=log)
        gateway.wait_active()
        self.assertEqual(found()["level"], "ok")


class Files(unittest.TestCase):
    """What is said of wrong files, and of a wrong command line."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="cansync_security_")
        self.addCleanup(shutil.rmtree, self.folder)
        self.ca = os.path.join(self.folder, "ca")
        made("init", self.ca)
        made("add", self.ca, "viewer", "--role", "viewer", "--bus", "can7")
        self.me = os.path.join(self.ca, "viewer")
        self.nobody = Place()

    def complaint(self, folder=None, bus="can7"):
        """What `cansync` says before it looks for a daemon."""
        result = subprocess.run(
            [os.environ["CANSYNC"], "--security", folder or self.me, "--bus", bus, "--timeout", "1", "status"], env=self.nobody.environment,
            capture_output=True, text=True, timeout=LONG, check=False)
        self.assertEqual(result.returncode, NOT_REACHABLE)
        return result.stderr

    def test_each_wrong_file_is_named_with_the_remedy(self):
        self.assertIn("no daemon found", self.complaint())
        self.assertIn("gives no right on bus can8", self.complaint(bus="can8"))
        key = os.path.join(self.me, "key.pem")
        os.chmod(key, 0o644)
        self.assertIn(f"chmod 600 {key}", self.complaint())
        os.chmod(key, 0o600)
        for name in glob.glob(os.path.join(self.me, "*")):
            os.rename(name, name + ".away")
            self.assertIn(f"{name}: is missing", self.complaint())
            os.rename(name + ".away", name)
        made("add", self.ca, "other", "--role", "viewer", "--bus", "can7")
        for name, words in (("key.pem", "is not the key of"), ("permissions.p7s", "both must come from the same")):
            kept = os.path.join(self.me, name)
            os.rename(kept, kept + ".away")
            shutil.copy(os.path.join(self.ca, "other", name), kept)
            self.assertIn(words, self.complaint())
            os.rename(kept + ".away", kept)
        with open(os.path.join(self.me, "governance.p7s"), "a+", encoding="utf-8") as file:
            file.seek(0)
            text = file.read()
            file.truncate(0)
            file.write(text.replace("ENCRYPT", "NONE"))
        self.assertIn("governance.p7s: is not signed by permissions_ca.pem, or was changed", self.complaint())

    def test_expired_certificate(self):
        made("add", self.ca, "late", "--role", "viewer", "--bus", "can7")
        late = os.path.join(self.ca, "late")
        subprocess.run(
            ["openssl", "req", "-new", "-key", os.path.join(late, "key.pem"), "-subj", "/CN=late",
             "-out", os.path.join(late, "request.pem")], check=True, capture_output=True, timeout=LONG)
        subprocess.run(
            ["openssl", "x509", "-req", "-in", os.path.join(late, "request.pem"), "-days", "-1", "-CA",
             os.path.join(self.ca, "identity_ca.pem"), "-CAkey", os.path.join(self.ca, "authority", "identity_ca.key"),
             "-set_serial", "7", "-out", os.path.join(late, "certificate.pem")],
            check=True, capture_output=True, timeout=LONG)
        said = self.complaint(late)
        self.assertIn("certificate.pem: expired on", said)
        self.assertIn("cansync-security renew", said)

    def test_nothing_is_overwritten_and_modes_are_strict(self):
        self.assertIn("not overwritten", security("init", self.ca).stderr)
        self.assertIn("not overwritten", security("add", self.ca, "viewer", "--role", "viewer").stderr)
        for path in glob.glob(os.path.join(self.ca, "**", "*"), recursive=True):
            self.assertEqual(os.stat(path).st_mode & 0o077, 0, path)

    @unittest.skipUnless(os.geteuid() == 0, "files are given to another user by root alone")
    def test_an_identity_is_put_in_place_and_a_renewed_one_takes_its_place(self):
        place = os.path.join(self.folder, "etc", "security")
        os.mkdir(os.path.dirname(place))
        user = "nobody" if any(one.pw_name == "nobody" for one in pwd.getpwall()) else "root"
        install = ("install", os.path.join(self.ca, "viewer"), "--to", place, "--user", user)
        made(*install)
        owner = pwd.getpwnam(user).pw_uid

        def content(folder):
            return {name: open(os.path.join(folder, name), "rb").read() for name in sorted(os.listdir(folder))}

        before = content(place)
        self.assertEqual(sorted(before), ["certificate.pem", "governance.p7s", "identity_ca.pem", "key.pem", "permissions.p7s",
                                          "permissions_ca.pem"])
        for path in (place, *glob.glob(os.path.join(place, "*"))):
            facts = os.stat(path)
            self.assertEqual((facts.st_uid, facts.st_mode & 0o077), (owner, 0), path)
        made("renew", self.ca, "viewer")
        made(*install)
        self.assertEqual(content(place), content(os.path.join(self.ca, "viewer")))
        self.assertNotEqual(content(place)["certificate.pem"], before["certificate.pem"])
        self.assertEqual(content(place + ".before"), before)
        self.assertEqual(sorted(os.listdir(os.path.dirname(place))), ["security", "security.before"])
        for arguments, words in (((self.folder,), "key.pem is missing"), ((*install[1:4], "--user", "nobody-such"), "does not exist"),
                                 ((install[1], "--to", self.folder, "--user", user), "holds no identity")):
            refused = security("install", *arguments)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(words, refused.stderr)

    def test_wrong_command_lines(self):
        for arguments, words in (((), "allowed: init, add, renew, install, list"), (("add", self.ca, "a/b", "--role", "viewer"), "NAME"),
                                 (("add", self.ca, "x", "--role", "king"), "--role"),
                                 (("init", self.ca + "2", "--days", "0"), "--days")):
            result = security(*arguments)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertIn(words, result.stderr)

    def test_daemon_checks_its_identity(self):
        config = os.path.join(self.folder, "line.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write('[bus]\nname = "can7"\ninterface = "sim"\n[dds]\nsecurity = "ca/viewer"\n[[slave]]\nnumber = 0\n')
        result = subprocess.run([os.environ["CANSYNCD"], "--check", config], capture_output=True, text=True,
                                timeout=LONG, check=False)
        self.assertEqual(result.returncode, 78)
        self.assertIn("line.toml:5:", result.stderr)
        self.assertIn("allowed: one made with --role daemon", result.stderr)


class Loopback(unittest.TestCase):
    def test_by_default_no_socket_hears_another_interface(self):
        with Gateway() as gateway:
            sockets = subprocess.run(["ss", "-ulnpH"], capture_output=True, text=True, timeout=LONG, check=True).stdout
            own = [line.split()[3] for line in sockets.splitlines() if f"pid={gateway.process.pid}," in line]
            self.assertTrue(own)
            for address in own:
                self.assertTrue(address.startswith("127.0.0.1:") or "%lo:" in address, own)


if __name__ == "__main__":
    unittest.main(verbosity=2)
