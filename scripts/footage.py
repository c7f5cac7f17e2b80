# SPDX-License-Identifier: MIT
"""Videos and tables for the scripts beside this file."""
import csv
import subprocess

# Shows two open hands of which one is annotated, and which one changes: no figures.
UNFIT_CLIPS = {"mason_wave"}
FINGERS = ["thumb", "index", "middle", "ring", "little"]


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def encoder(path, width, height, preset, crf):
    """An ffmpeg that takes BGR frames of this size, 30 a second, at its standard input."""
    return subprocess.Popen(
        ["ffmpeg", "-v", "error", "-f", "rawvideo", "-pix_fmt", "bgr24", "-s", f"{width}x{height}", "-r", "30", "-i", "-",
         "-c:v", "libx264", "-preset", preset, "-crf", str(crf), "-pix_fmt", "yuv420p", path], stdin=subprocess.PIPE)


def recode(video, path, filter_, crf):
    """Writes a video anew, frame by frame, through a filter of ffmpeg and as coarsely as `crf`."""
    subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-map", "0:v:0", "-vf", filter_, "-c:v", "libx264", "-preset",
                    "veryfast", "-crf", str(crf), "-fps_mode", "passthrough", "-pix_fmt", "yuv420p", path], check=True)


def finish(video):
    video.stdin.close()
    if video.wait():
        raise SystemExit("ffmpeg failed")
