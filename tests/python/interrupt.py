"""Ctrl-C while the package waits."""

import os
import signal
import sys
import threading
import time

from line import LONG

SOON = 0.1  # seconds after which Ctrl-C has ended a wait


def seconds_to_end(function, call, elsewhere=False):
    """Seconds from Ctrl-C, which comes when the main thread is in `function` of the package, to the end of `call`.

    elsewhere: another thread takes the signal, which then wakes no wait of the main thread
    """
    sent = []
    over = threading.Event()

    def watch():
        main = threading.main_thread().ident
        while not over.is_set():
            frame = sys._current_frames()[main]
            while frame is not None and frame.f_code.co_name != function:
                frame = frame.f_back
            if frame is not None:
                # That this thread runs shows that the one that waits does not hold the interpreter's lock.
                sent.append(time.monotonic())
                if elsewhere:
                    signal.pthread_kill(threading.get_ident(), signal.SIGINT)
                else:
                    os.kill(os.getpid(), signal.SIGINT)
                return
            time.sleep(0.001)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        given = call()
    except KeyboardInterrupt:
        return time.monotonic() - sent[0]
    finally:
        over.set()
        watcher.join(LONG)
    raise AssertionError(f"{function} was not ended by Ctrl-C, and gave {given}")
