// SPDX-License-Identifier: MIT
#include "handyar/io/pose_csv.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>

#include "handyar/io/csv_row.hpp"
#include "handyar/io/error.hpp"

namespace handyar::io {

const std::string_view kPoseCsvHeader =
    "frame,time_s,state,layout,"
    "thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,little_x,little_y,"
    "qw,qx,qy,qz,tx_m,ty_m,tz_m,"
    "raw_qw,raw_qx,raw_qy,raw_qz,raw_tx_m,raw_ty_m,raw_tz_m,"
    "rms_px,sigma_rotation_rad,sigma_translation_m,"
    "segmentation_ms,fingertips_ms,matching_ms,pose_ms,filter_ms,total_ms,"
    "doubtful,face,hand";

std::string pose_csv_row(std::int64_t frame, const TrackResult& result, bool timings, int hand) {
  CsvRow row;
  row.text(std::to_string(frame));
  row.number(result.time_s, kTimeDigits);
  row.text(name(result.state));
  row.text(result.layout ? name(*result.layout) : "");
  for (const Tip& tip : result.tips) {
    if (tip.known()) {
      row.number(tip.px.x(), kPixelDigits);
      row.number(tip.px.y(), kPixelDigits);
    } else {
      row.empty(2);
    }
  }
  result.pose ? row.pose(result.pose->T_camera_hand) : row.empty(7);
  result.raw_pose ? row.pose(result.raw_pose->T_camera_hand) : row.empty(7);
  row.number(result.raw_pose ? result.raw_pose->rms_px : NAN, kPixelDigits);
  if (result.pose || result.raw_pose) {
    const Matrix6d& covariance =
        result.pose ? result.pose->covariance : result.raw_pose->covariance;
    row.number(sigma_rotation_rad(covariance), kSigmaDigits);
    row.number(sigma_translation_m(covariance), kSigmaDigits);
  } else {
    row.empty(2);
  }
  const StageTimes& t = result.times;
  for (const double ms :
       {t.segmentation_ms, t.fingertips_ms, t.matching_ms, t.pose_ms, t.filter_ms, t.total_ms}) {
    row.number(timings ? ms : NAN, kMillisecondDigits);
  }
  row.text(result.doubtful ? "1" : "0");
  row.text(result.face ? name(*result.face) : "");
  row.text(std::to_string(hand));
  return row.take();
}

PoseCsvWriter::PoseCsvWriter(const std::string& path, bool timings)
    : file_(path), stream_(file_.stream()), timings_(timings) {
  put(std::string(kPoseCsvHeader));
}

void PoseCsvWriter::put(const std::string& line) {
  errno = 0;
  stream_ << line << '\n';
  if (stream_) return;
  throw Error(file_.target(), std::string("cannot be written: ") +
                                  (errno != 0 ? std::strerror(errno) : "unknown reason"));
}

void PoseCsvWriter::write(std::int64_t frame, const TrackResult& result, int hand) {
  put(pose_csv_row(frame, result, timings_, hand));
}

void PoseCsvWriter::finish() {
  errno = 0;
  stream_.close();
  if (!stream_) {
    throw Error(file_.target(), std::string("cannot be written: ") +
                                    (errno != 0 ? std::strerror(errno) : "unknown reason"));
  }
  file_.commit();
}

}  // namespace handyar::io
