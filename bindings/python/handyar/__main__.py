# SPDX-License-Identifier: MIT
"""python3 -m handyar: the program handyar, with the same arguments."""

import os
import shutil
import sys
from pathlib import Path


def main() -> None:
    # Beside this Python when it was installed with it, else wherever a shell would find it.
    program = shutil.which("handyar", path=str(Path(sys.executable).parent)) or shutil.which(
        "handyar"
    )
    if program is None:
        sys.exit("handyar: the program is not installed: it is neither beside Python nor on the PATH")
    os.execv(program, ["handyar", *sys.argv[1:]])


main()
