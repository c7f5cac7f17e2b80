# SPDX-License-Identifier: MIT
"""python3 -m handyar: the program handyar, with the same arguments."""

import os
import shutil
import sys
from pathlib import Path


def main() -> None:
    # Of the same build, or beside this Python when it was installed with it, else wherever a shell
    # would find it.
    build = Path(__file__).parent / "../../../apps/handyar"
    folders = os.pathsep.join([str(build.resolve()), str(Path(sys.executable).parent)])
    program = shutil.which("handyar", path=folders) or shutil.which("handyar")
    if program is None:
        sys.exit("handyar: the program is not installed: it is neither beside Python nor on the PATH")
    os.execv(program, ["handyar", *sys.argv[1:]])


main()
