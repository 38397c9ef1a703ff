"""Pages of libraries are let go where nothing is lost by it."""

import subprocess
import sys

from campusloop.live.memory.library_pages import _unchanged

_MAPPINGS = """\
7f0000000000-7f0000100000 r-xp 00001000 fe:00 12 {spaces}/site/libllvmlite.so
Rss:                 900 kB
Anonymous:             0 kB
7f0000100000-7f0000180000 r--p 00101000 fe:00 12 {spaces}/site/libllvmlite.so
Rss:                 100 kB
Anonymous:             8 kB
7f0000180000-7f0000200000 rw-p 00181000 fe:00 12 {spaces}/site/libllvmlite.so
Anonymous:             0 kB
7f0000200000-7f0000280000 r--s 00000000 fe:00 13 {spaces}/var/campusloop.db-shm
Anonymous:             0 kB
7f0000280000-7f0000300000 rw-p 00000000 00:00 0
Anonymous:             0 kB
"""


def test_pages_that_were_written_or_are_no_librarys_are_kept() -> None:
    assert list(_unchanged(_MAPPINGS.format(spaces=" " * 8))) == [(0x7F0000000000, 0x7F0000100000)]


def test_libraries_work_on_when_their_pages_are_gone() -> None:
    """In a process of its own, which would end by a signal if a changed page were lost."""
    program = (
        "import ssl, numpy as np\n"
        "from campusloop.live.memory.library_pages import let_go_of_library_pages\n"
        "let_go_of_library_pages()\n"
        "assert np.allclose(np.linalg.inv(2.0 * np.eye(50)), 0.5 * np.eye(50))\n"
        "ssl.create_default_context()\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60.0)
