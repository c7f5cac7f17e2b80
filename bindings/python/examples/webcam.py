# SPDX-License-Identifier: MIT
"""Follows the hand before the first webcam and draws what is found; q ends."""
import time

import cv2
import handyar

video = cv2.VideoCapture(0)
size = int(video.get(cv2.CAP_PROP_FRAME_WIDTH)), int(video.get(cv2.CAP_PROP_FRAME_HEIGHT))
camera = handyar.Camera.from_field_of_view(*size)  # or handyar.io.read_camera("camera.yml")
tracker = handyar.Tracker(camera, handyar.average_adult_hand())

while cv2.waitKey(1) != ord("q"):
    there, frame = video.read()
    if not there:
        break
    result = tracker.process(frame, time.monotonic())
    if result.pose is not None:
        print("hand at", result.pose[:3, 3].round(3), "m")
    handyar.draw.annotate(frame, tracker, result)
    cv2.imshow("handyar", frame)
