// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/fiducial_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/parallel.h"
#include "collinea/camera/film_fit.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// A part of a scan at a reduced size: means of factor x factor pixels.
FloatImage reduced(const GreyImage& scan, int left, int top, int width, int height, int factor) {
  FloatImage out(width / factor, height / factor);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      int sum = 0;
      for (int j = 0; j < factor; ++j) {
        const std::uint8_t* row = scan.row(top + y * factor + j) + left + x * factor;
        for (int i = 0; i < factor; ++i) sum += row[i];
      }
      out.at(x, y) = float(sum) / float(factor * factor);
    }
  return out;
}

// A drawing at that size, with the mark in the middle of its middle pixel, less its mean.
FloatImage reduced(const MarkTemplate& drawing, int factor) {
  const int half = std::max(1, int(0.85 * drawing.half_px()) / factor);
  FloatImage out(2 * half + 1, 2 * half + 1);
  const int fine = std::max(1, int(std::lround(factor / drawing.spacing_px)));
  float mean = 0;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      float sum = 0;
      for (int k = 0; k < fine * fine; ++k) {
        const Vector2d cell((k % fine + 0.5) / fine - 0.5, (k / fine + 0.5) / fine - 0.5);
        const Vector2d at = drawing.centre + (Vector2d(x - half, y - half) + cell) * (factor / drawing.spacing_px);
        sum += bilinear(drawing.values, at.x(), at.y());
      }
      mean += out.at(x, y) = sum / float(fine * fine);
    }
  mean /= float(out.data.size());
  for (float& value : out.data) value -= mean;
  return out;
}

// The correlation coefficient of the template with the pixels whose upper left one is x, y.
float correlation(const FloatImage& image, const FloatImage& drawing, float drawing_norm, int x, int y) {
  float sum = 0, squares = 0, products = 0;
  for (int j = 0; j < drawing.height; ++j) {
    const float *pixels = image.row(y + j) + x, *drawn = drawing.row(j);
    for (int i = 0; i < drawing.width; ++i) {
      sum += pixels[i];
      squares += pixels[i] * pixels[i];
      products += pixels[i] * drawn[i];
    }
  }
  const float count = float(drawing.data.size()), spread = squares - sum * sum / count;
  return spread > 0.5F * count ? products / (drawing_norm * std::sqrt(spread)) : 0;
}

// Largest values of a map in their neighbourhood, best first.
std::vector<std::pair<float, Vector2d>> peaks(const FloatImage& map, int reach, std::size_t most) {
  std::vector<std::pair<float, Vector2d>> out;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const float value = map.at(x, y);
      if (value < 0.3F) continue;
      bool is_largest = true;
      for (int j = std::max(0, y - reach); is_largest && j <= std::min(map.height - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(map.width - 1, x + reach); ++i)
          is_largest &=
              map.at(i, j) < value || (i == x && j == y) || (map.at(i, j) == value && (j > y || (j == y && i > x)));
      if (is_largest) out.emplace_back(value, Vector2d(x, y));
    }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace

std::vector<FoundMark> search_mark(const GreyImage& scan, const MarkModel& mark, const Vector2d& predicted,
                                   double radius_px, int most) {
  if (mark.blurred.empty() || !predicted.allFinite()) return {};
  const MarkTemplate& drawing = mark.blurred[mark.blurred.size() / 2];
  const int factor = std::max(1, int(drawing.half_px() / 9));
  const double reach = radius_px + drawing.half_px();
  const int left = int(std::clamp(predicted.x() - reach, 0.0, double(scan.width)));
  const int top = int(std::clamp(predicted.y() - reach, 0.0, double(scan.height)));
  const int right = int(std::clamp(predicted.x() + reach, 0.0, double(scan.width)));
  const int bottom = int(std::clamp(predicted.y() + reach, 0.0, double(scan.height)));
  const FloatImage part = reduced(scan, left, top, right - left, bottom - top, factor),
                   small = reduced(drawing, factor);
  if (part.width < small.width || part.height < small.height) return {};
  float norm = 0;
  for (const float value : small.data) norm += value * value;
  norm = std::sqrt(norm);
  FloatImage map(part.width - small.width + 1, part.height - small.height + 1);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) map.at(x, y) = std::abs(correlation(part, small, norm, x, y));
  std::vector<FoundMark> found;
  for (const auto& [value, at] : peaks(map, std::max(1, small.width / 6), 4 * std::size_t(most))) {
    const Vector2d start = Vector2d(left, top) + factor * (at + Vector2d(small.width, small.height) / 2);
    if (found.size() >= 2 * std::size_t(most)) break;
    const auto match = match_mark(scan, mark, start);
    if (!match || (match->pixel - predicted).norm() > radius_px) continue;
    const auto is_same = [&](const FoundMark& other) {
      return (other.pixel - match->pixel).norm() < 0.1 * drawing.half_px();
    };
    if (std::none_of(found.begin(), found.end(), is_same)) found.push_back(*match);
  }
  std::stable_sort(found.begin(), found.end(), [](const FoundMark& a, const FoundMark& b) {
    return std::abs(a.correlation) > std::abs(b.correlation);
  });
  if (found.size() > std::size_t(most)) found.resize(std::size_t(most));
  return found;
}

namespace {

// The direction from a mark to the inside of the photograph, on the film with y down: along an axis from marks in the
// middle of a side, at 45 degrees from those in corners. Crosses stand upright.
double inwards_of(MarkKind kind, const Vector2d& film_mm) {
  if (kind != MarkKind::kCorner && kind != MarkKind::kNotch) return 0;
  const Vector2d d(-film_mm.x(), film_mm.y());
  const double eighth = std::numbers::pi / 4;
  return eighth * std::round(std::atan2(d.y(), d.x()) / eighth);
}

// One likeness or more of a mark.
struct Likenesses {
  std::vector<MarkModel> models;
  bool is_learnt = false;
};

struct Candidate {
  std::size_t mark, likeness;
  FoundMark found;
};

bool is_diagonal(const CalibratedMark& mark) {
  const double x = std::abs(mark.film_mm.x()), y = std::abs(mark.film_mm.y());
  return std::min(x, y) > 0.4 * std::max(x, y);
}

// The likeness that was pointed to for marks of this kind: of one that lies in a corner too, or in a side too, where
// there is one. Nothing: the mark is drawn.
const LearntMark* learnt_for(const CalibratedMark& mark, const std::vector<LearntMark>& all) {
  const LearntMark* best = nullptr;
  for (const LearntMark& one : all) {
    if (one.mark.kind != mark.kind) continue;
    if (!best || (is_diagonal(best->mark) != is_diagonal(mark) && is_diagonal(one.mark) == is_diagonal(mark)))
      best = &one;
  }
  return best;
}

Likenesses likenesses_of(const CalibratedMark& mark, const FiducialSearch& search, const FilmCalibration& calibration) {
  if (const LearntMark* learnt = learnt_for(mark, search.learnt)) return {likenesses(*learnt), true};
  const double scale = search.predicted.parameters[3];
  const MarkKind kind = mark.kind.value_or(search.kind);
  return {{drawn_mark(kind, scale * calibration.mark_size_mm, scale * calibration.line_mm,
                      inwards_of(kind, mark.film_mm) + search.predicted.parameters[2])}};
}

// Positions that look most like any of the likenesses. One that was pointed to is bright where it is bright.
constexpr double kLeastLearnt = 0.7;  // correlation of marks of one camera in its scans
std::vector<Candidate> candidates_of(const GreyImage& scan, const Likenesses& like, std::size_t mark,
                                     const Vector2d& predicted, double radius_px) {
  std::vector<Candidate> out;
  for (std::size_t k = 0; k < like.models.size(); ++k)
    for (const FoundMark& found : search_mark(scan, like.models[k], predicted, radius_px, 3))
      if (!like.is_learnt || found.correlation >= kLeastLearnt) out.push_back({mark, k, found});
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) {
    return std::abs(a.found.correlation) > std::abs(b.found.correlation);
  });
  // Of one position the likeness that fits best.
  std::vector<Candidate> kept;
  for (const Candidate& one : out)
    if (std::none_of(kept.begin(), kept.end(), [&](const Candidate& other) {
          return (other.found.pixel - one.found.pixel).norm() < 0.2 * like.models[0].blurred[0].half_px();
        }))
      kept.push_back(one);
  if (kept.size() > 3) kept.erase(kept.begin() + 3, kept.end());
  return kept;
}

// The similarity of two candidates, if it is near the predicted one.
std::optional<FilmTransformation> similarity_of(const FilmMark& a, const FilmMark& b, const FilmTransformation& near) {
  const FilmMark pair[] = {a, b};
  const Vector2d q(b.film_mm.x() - a.film_mm.x(), a.film_mm.y() - b.film_mm.y()), p = b.pixel - a.pixel;
  if (!(q.norm() > 1)) return std::nullopt;
  FilmTransformation t = near;
  t.parameters[3] = p.norm() / q.norm();
  t.parameters[2] = std::atan2(q.x() * p.y() - q.y() * p.x(), q.dot(p));
  t.parameters.head<2>().setZero();
  t.parameters.head<2>() = (pair[0].pixel + pair[1].pixel - t.pixel_of(a.film_mm) - t.pixel_of(b.film_mm)) / 2;
  const double turned = std::remainder(t.parameters[2] - near.parameters[2], 2 * std::numbers::pi);
  if (std::abs(turned) > 5 * std::numbers::pi / 180) return std::nullopt;
  if (std::abs(t.parameters[3] / near.parameters[3] - 1) > 0.05) return std::nullopt;
  return t;
}

// How far a candidate is from its mark [px]; of a mark of one coordinate from its line.
double distance_of(const Candidate& candidate, const CalibratedMark& mark, const FilmTransformation& t) {
  const Vector2d off = candidate.found.pixel - t.pixel_of(mark.film_mm);
  if (mark.coordinates == MarkCoordinates::kBoth) return off.norm();
  const Vector2d along = t.by_film(mark.film_mm).col(mark.coordinates == MarkCoordinates::kX ? 1 : 0).normalized();
  return std::abs(along.x() * off.y() - along.y() * off.x());
}

// Of each mark the candidate that a similarity predicts, within 0.2 mm; and the sum of their correlations.
std::pair<double, std::vector<const Candidate*>> agreeing(const FilmTransformation& t,
                                                          const FilmCalibration& calibration,
                                                          const std::vector<Candidate>& candidates) {
  std::vector<const Candidate*> best(calibration.marks.size(), nullptr);
  for (const Candidate& candidate : candidates) {
    if (distance_of(candidate, calibration.marks[candidate.mark], t) > 0.2 * t.parameters[3]) continue;
    const Candidate*& kept = best[candidate.mark];
    if (!kept || std::abs(candidate.found.correlation) > std::abs(kept->found.correlation)) kept = &candidate;
  }
  double score = 0;
  for (const Candidate* one : best)
    if (one) score += std::abs(one->found.correlation);
  return {score, best};
}

}  // namespace

FilmTransformation predicted_scan(const FilmCalibration& calibration, int width_px, int height_px,
                                  std::optional<double> pixel_mm, int quarter_turns) {
  const bool is_across = quarter_turns % 2 != 0;
  const double width = is_across ? calibration.size_mm.y() : calibration.size_mm.x();
  const double height = is_across ? calibration.size_mm.x() : calibration.size_mm.y();
  FilmTransformation t;
  t.model = FilmModel::kSimilarity;
  const double scale = pixel_mm ? 1 / *pixel_mm : std::sqrt(width_px / width * (height_px / height));
  t.parameters = Eigen::Vector4d(width_px / 2.0, height_px / 2.0, quarter_turns * std::numbers::pi / 2, scale);
  return t;
}

namespace {

// The tone of a scan before its marks are seen: between linear grey values and the power 2.2 of common scanners.
constexpr double kTone = 1.5, kToneSigma = 1.0, kLeastTone = -2, kMostTone = 5;

struct Tone {
  double value = kTone, sigma = kToneSigma, information = 1 / (kToneSigma * kToneSigma);
};

// Marks that were chosen, with their drawings.
struct Chosen {
  std::size_t mark;
  const MarkModel* model;
  bool is_learnt;
  FoundMark found;
};

// A likeness has the grey values of the scan; how the scan was turned from which it comes is not known.
void match_all(const GreyImage& scan, const MarkPrior& prior, const Run& run, std::vector<Chosen>& marks) {
  parallel_for(run, marks.size(), [&](std::size_t i) {
    MarkPrior known = marks[i].is_learnt ? MarkPrior{} : prior;
    known.blur_px = marks[i].found.blur_px;
    if (const auto again = match_mark(scan, *marks[i].model, marks[i].found.pixel, known)) marks[i].found = *again;
  });
}

// The tone of a scan from all its marks together: the one by which the squares of all their residuals are least. Steps
// of Newton's, each with all marks matched anew.
Tone tone_of(const GreyImage& scan, MarkPrior prior, const Run& run, std::vector<Chosen>& marks) {
  Tone tone;
  for (int round = 0; round < 12; ++round) {
    prior.tone = tone.value;
    match_all(scan, prior, run, marks);
    const double known = 1 / (kToneSigma * kToneSigma);
    double slope = known * (kTone - tone.value), information = known, variance = known;
    for (const Chosen& one : marks) {
      if (one.is_learnt) continue;
      slope += one.found.tone.slope;
      information += one.found.tone.information;
      variance += one.found.tone.variance;
    }
    // Shorter when they go to and fro.
    const double step = std::clamp(slope / information, -0.5, 0.5) * (round < 5 ? 1 : 0.5);
    tone = {std::clamp(tone.value + step, kLeastTone, kMostTone), std::sqrt(variance) / information, information};
    if (std::abs(step) < 0.05 * tone.sigma) break;
  }
  return tone;
}

// The chosen candidates, matched with the rotation and the tone that all of them together have.
std::vector<FoundFiducial> matched_again(const GreyImage& scan, const FilmCalibration& calibration,
                                         const std::vector<const Candidate*>& chosen,
                                         const std::vector<Likenesses>& likenesses, const FilmTransformation& near,
                                         const Run& run) {
  std::vector<FilmMark> marks;
  std::vector<Chosen> found;
  for (const Candidate* one : chosen)
    if (one) {
      marks.push_back({"", calibration.marks[one->mark].film_mm, one->found.pixel});
      const Likenesses& like = likenesses[one->mark];
      found.push_back({one->mark, &like.models[one->likeness], like.is_learnt, one->found});
    }
  if (marks.size() < 3) return {};
  const auto fit = fit_film(marks, FilmModel::kSimilarity, {.reject_misread = false});
  if (!fit) return {};
  const double rotation = std::remainder(fit->transformation.parameters[2] - near.parameters[2], 2 * std::numbers::pi);
  MarkPrior prior{rotation, 0.001, 0.03, 0.001};
  if (std::any_of(found.begin(), found.end(), [](const Chosen& one) { return !one.is_learnt; })) {
    const Tone tone = tone_of(scan, prior, run, found);
    prior.tone = tone.value;
    prior.sigma_tone = tone.sigma;
    prior.tone_information = tone.information;
  }
  match_all(scan, prior, run, found);
  std::vector<FoundFiducial> out;
  for (const Chosen& one : found) out.push_back({calibration.marks[one.mark].name, one.found});
  return out;
}

}  // namespace

std::vector<FoundFiducial> find_fiducials(const GreyImage& scan, const FilmCalibration& calibration,
                                          const FiducialSearch& search, const Run& run) {
  const FilmTransformation& near = search.predicted;
  const double scale = near.parameters[3];
  std::vector<std::vector<Candidate>> of_mark(calibration.marks.size());
  std::vector<Likenesses> likenesses(calibration.marks.size());
  parallel_for(run, of_mark.size(), [&](std::size_t i) {
    const CalibratedMark& mark = calibration.marks[i];
    likenesses[i] = likenesses_of(mark, search, calibration);
    of_mark[i] = candidates_of(scan, likenesses[i], i, near.pixel_of(mark.film_mm), scale * search.radius_mm);
  });
  std::vector<Candidate> candidates;
  for (const auto& of_one : of_mark) candidates.insert(candidates.end(), of_one.begin(), of_one.end());
  std::pair<double, std::vector<const Candidate*>> best{0, {}};
  const auto as_mark = [&](const Candidate& one) {
    return FilmMark{.name = {}, .film_mm = calibration.marks[one.mark].film_mm, .pixel = one.found.pixel};
  };
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = i + 1; j < candidates.size(); ++j) {
      if (candidates[i].mark == candidates[j].mark) continue;
      const auto t = similarity_of(as_mark(candidates[i]), as_mark(candidates[j]), near);
      if (!t) continue;
      auto agreed = agreeing(*t, calibration, candidates);
      if (agreed.first > best.first) best = std::move(agreed);
    }
  return matched_again(scan, calibration, best.second, likenesses, near, run);
}

}  // namespace collinea
