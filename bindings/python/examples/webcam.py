# SPDX-License-Identifier: MIT
"""Follows the hand before the first webcam and draws what is found; q ends."""
import time

import cv2
import handyar

video = cv2.VideoCapture(0)
tracker = handyar.Tracker()  # or with a camera and a hand from files

while cv2.waitKey(1) != ord("q"):
    there, frame = video.read()
    if not there:
        break
    result = tracker.process(frame, time.monotonic())
    if result.pose is not None:
        print("hand at", result.pose[:3, 3].round(3), "m")
    handyar.draw.annotate(frame, tracker, result)
    cv2.imshow("handyar", frame)
