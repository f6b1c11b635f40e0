"""One run of klang under limits, and what must hold of it whatever its input was (tools/attack)."""
import base64
import dataclasses
import os
import pathlib
import re
import resource
import shlex
import signal
import subprocess
import threading
import time

SECONDS = 20          # of the clock, or of a processor where the program had less than one
ADDRESSES = 12 << 30  # of address space: threads and libraries take 2 GB of it without using them
FILE_BYTES = 2 << 30


@dataclasses.dataclass
class Result:
    code: int
    seconds: float
    memory_mb: float
    stderr: str


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CPU, (2 * SECONDS, 2 * SECONDS))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def execute(arguments, folder):
    with open(folder / ".stderr", "w+b") as errors:
        start = time.monotonic()
        process = subprocess.Popen(arguments, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors,
                                   preexec_fn=limits, start_new_session=True)
        timer = threading.Timer(12 * SECONDS, lambda: os.killpg(process.pid, signal.SIGKILL))
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - start
        errors.seek(0)
        text = errors.read(1 << 20).decode("utf-8", "replace")
    (folder / ".stderr").unlink()
    # On a machine that others use as well the processor's time says more than the clock.
    busy = min(seconds, usage.ru_utime + usage.ru_stime)
    return Result(process.returncode, busy, usage.ru_maxrss / 1024, text)


def own_scripts():
    """Texts of the scripts that the program puts into its pages."""
    web = pathlib.Path(__file__).resolve().parent.parent.parent / "reports/pages/web"
    return {path.read_text("utf-8").strip() for path in web.rglob("*.js")}


def is_own_script(target):
    head = "data:text/javascript;base64,"
    return target.startswith(head) and base64.b64decode(target[len(head):]).decode("utf-8").strip() in own_scripts()


def links(folder):
    """Targets of a page's links and media that are neither beside it nor in it, and scripts that are not the program's own."""
    for page in folder.rglob("*.html"):
        for target in re.findall(r"""\b(?:href|src)\s*=\s*["']([^"']*)""", page.read_text("utf-8", "replace"), re.I):
            if not re.match(r"(#|\./(?!/)|data:(image|audio)/|figures/)", target) and not is_own_script(target):
                yield target


def run(klang, command, folder, allowed_codes, memory_mb):
    """(what is wrong, Result)"""
    before = {p for p in folder.rglob("*")}
    result = execute([klang, *shlex.split(command)], folder)
    faults = []
    if result.code < 0:
        faults.append(f"ended by signal {-result.code}")
    elif result.code not in allowed_codes:
        faults.append(f"exit code {result.code}, not {sorted(allowed_codes)}")
    if result.seconds > SECONDS:
        faults.append(f"took {result.seconds:.0f} s")
    if result.memory_mb > memory_mb:
        faults.append(f"took {result.memory_mb:.0f} MB")
    lines = [line for line in result.stderr.splitlines() if line]
    foreign = [line for line in lines if not line.startswith("klang: ")]
    if foreign:
        faults.append(f"line of another on stderr: {foreign[0][:120]!r}")
    complaints = [line for line in lines if not re.match("klang: (warning|note): ", line)]
    if result.code in (2, 3) and len(complaints) != 1:
        faults.append(f"{len(complaints)} lines of complaint")
    if any(len(line) > 2000 for line in lines):
        faults.append("a line of more than 2000 characters")
    left = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p not in before)
    if result.code in (2, 3) and left:
        faults.append(f"left behind: {left[:3]}")
    if any("/." in "/" + name for name in left):
        faults.append("temporary files left behind")
    faults += [f"a page links to {target[:80]!r}" for target in links(folder)]
    return faults, result
