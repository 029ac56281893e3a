// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/finding_words.h"

#include <gtest/gtest.h>

#include <set>

#include "collinea/report/internal/finding_json.h"

namespace collinea {
namespace {

Block named_block() {
  Block block;
  block.cameras[{0}].name = "FC6310";
  for (std::uint32_t i = 0; i < 9; ++i) block.images[{i}] = {"IMG_" + std::to_string(i) + ".jpg", CameraId{0}};
  for (std::uint32_t i = 0; i < 3; ++i) block.control[{i}].name = "P" + std::to_string(i);
  block.geodetic.push_back({.kind = GeodeticKind::kDistance, .from = {0}, .to = {1}});
  block.geodetic.push_back({.kind = GeodeticKind::kDistance, .from = {1}, .to = {2}});
  return block;
}

// A finding of that code with every figure that its row in the table lists, and subjects of many kinds.
Finding sample_of(FindingCode code) {
  Finding finding = finding_of(code, {}, {}, {}, "because");
  double value = 0.3;
  for (const FigureName name : figures_of(code)) finding.figures.push_back({name, value += 1.25});
  if (code == FindingCode::kDatumDefect) {
    finding.subjects = {Subject(Aspect::kScale), Subject(Aspect::kRotation)};
  } else if (code == FindingCode::kFocalAndHeight) {
    finding.subjects = {Subject(CameraId{0}, Aspect::kDistance), Subject(CameraId{0}, Aspect::kParameter, Camera::kF)};
  } else if (code == FindingCode::kCameraAndPose) {
    finding.subjects = {Subject(CameraId{0}, Aspect::kDistance), Subject(CameraId{0}, Aspect::kParameter, Camera::kCx)};
  } else if (code == FindingCode::kParameterNotDetermined) {
    finding.subjects = {Subject(CameraId{0}, Aspect::kParameter, Camera::kK1)};
  } else if (code == FindingCode::kInstrument) {
    finding.subjects = {Subject(SubjectKind::kStrip, 0, Aspect::kShift)};
  } else if (code == FindingCode::kSystematic) {
    finding.subjects = {Subject(CameraId{0}, Aspect::kTimeOffset), Subject(CameraId{0}, Aspect::kLeverArm)};
  } else {
    finding.subjects = {ImageId{1}, ControlId{2}};
  }
  return finding;
}

// Its sentence is more than its code, and every figure that it names is there: one that is not would read "nan".
TEST(FindingWords, EveryCodeHasASentenceOfFiguresThatItCarries) {
  const Block block = named_block();
  std::set<std::string> sentences;
  for (std::size_t i = 0; i < kFindingCodes; ++i) {
    const Finding finding = sample_of(static_cast<FindingCode>(i));
    const std::string what = what_of(finding, block);
    EXPECT_NE(what, std::string(word_of(finding.code)) + ".");
    EXPECT_EQ(what.find("nan"), std::string::npos) << what;
    EXPECT_TRUE(what.ends_with(".")) << what;
    EXPECT_FALSE(what.front() >= 'a' && what.front() <= 'z') << what;
    EXPECT_TRUE(sentences.insert(what).second) << what;
  }
}

TEST(FindingWords, ReasonsOfSkippedImagesStandBesideTheirNames) {
  const Block block = named_block();
  const Subject file = Subject::file("a/b.jpg");
  const auto reason = [&](FindingCode code, std::vector<Subject> subjects, const char* detail) {
    return reason_of(finding_of(code, std::move(subjects), {{FigureName::kLimit, 64}}, {}, detail), block);
  };
  EXPECT_EQ(reason(FindingCode::kImageUnreadable, {file}, "is empty"), "is empty");
  EXPECT_EQ(reason(FindingCode::kImageTooSmall, {file}, ""), "smaller than 64 x 64 pixels");
  EXPECT_EQ(reason(FindingCode::kImageDuplicate, {file, Subject::file("a/a.jpg")}, ""), "the same bytes as a/a.jpg");
  EXPECT_EQ(reason(FindingCode::kFolderUnreadable, {file}, "Permission denied"), "cannot be read: Permission denied");
  EXPECT_EQ(reason(FindingCode::kNoDepthMap, {ImageId{3}}, "no neighbours"), "no depth map: no neighbours");
  EXPECT_EQ(what_of(finding_of(FindingCode::kImageDuplicate, {file, Subject::file("a/a.jpg")}), block),
            "Image a/b.jpg is skipped: the same bytes as a/a.jpg.");
}

TEST(FindingWords, WordsDoNotDependOnTheSeverity) {
  for (std::size_t i = 0; i < kFindingCodes; ++i)
    for (const Severity severity : {Severity::kNote, Severity::kWeak, Severity::kWrong}) {
      Finding finding = sample_of(static_cast<FindingCode>(i));
      const std::string before = sentence_of(finding, named_block());
      finding.severity = severity;
      EXPECT_EQ(sentence_of(finding, named_block()), before);
    }
}

TEST(FindingWords, EveryRemedyHasAPhraseOfItsOwn) {
  std::set<std::string> phrases;
  for (std::size_t i = 0; i < kRemedyCodes; ++i) {
    Finding finding = finding_of(FindingCode::kLocalGauge);
    const auto code = static_cast<RemedyCode>(i);
    finding.remedies = {code == RemedyCode::kSetOption ? Remedy(OptionName{"calibration", "orient", "none"})
                                                       : Remedy(code)};
    const std::string phrase = remedy_of(finding);
    EXPECT_GT(phrase.size(), 8u) << word_of(code);
    EXPECT_TRUE(phrases.insert(phrase).second) << phrase;
  }
}

TEST(FindingWords, OptionsAreSpeltAsTheFaceKnowsThem) {
  Finding finding = finding_of(FindingCode::kLocalGauge, {}, {}, {OptionName{"time_offset", "orient"}});
  EXPECT_EQ(remedy_of(finding), "See option time_offset.");
  EXPECT_EQ(remedy_of(finding, [](const OptionName& option) { return "--" + option.name; }), "See --time_offset.");
  finding.remedies = {RemedyCode::kCalibrateCamera, OptionName{"calibration", "orient", "none"}};
  EXPECT_EQ(remedy_of(finding), "Give a calibrated camera, or set option calibration = none.");
}

TEST(FindingWords, OneControlPointTwoAndALineAreNamed) {
  const Block block = named_block();
  Finding defect =
      finding_of(FindingCode::kDatumDefect, {Subject(Aspect::kScale), Subject(Aspect::kAttitude), ControlId{1}},
                 {{FigureName::kDefect, 4}}, {RemedyCode::kGiveScale, RemedyCode::kGiveControlForAttitude});
  EXPECT_EQ(what_of(defect, block), "Nothing fixes the scale and the attitude (there is one control point: P1).");
  EXPECT_NE(remedy_of(defect).find("for the scale and give two more"), std::string::npos) << remedy_of(defect);
  defect.subjects = {Subject(Aspect::kRotation), ControlId{0}, ControlId{2}, ImageId{4}};
  defect.figures = {{FigureName::kDefect, 1}, {FigureName::kAzimuth, 90}, {FigureName::kSteepness, 0}};
  EXPECT_EQ(what_of(defect, block),
            "Nothing fixes the rotation about the line through P0 and P2 of the part with IMG_4.jpg.");
  defect.subjects = {Subject(Aspect::kRotation)};
  EXPECT_EQ(what_of(defect, block),
            "Nothing fixes the rotation about a level axis with the azimuth 90 degrees, the line on which all that is "
            "known lies.");
}

TEST(FindingWords, WrongControlIsNamedWithWhereItIsOff) {
  const Block block = named_block();
  const auto off = [&](double plan, double height) {
    return what_of(finding_of(FindingCode::kControlPoint, {ControlId{2}},
                              {{FigureName::kOffset, std::hypot(plan, height)},
                               {FigureName::kOffsetPlan, plan},
                               {FigureName::kOffsetHeight, height}}),
                   block);
  };
  EXPECT_EQ(off(0.1, -5),
            "The coordinates of P2 differ by 5.00 m in height from what the other points show. The point is not used.");
  EXPECT_NE(off(100, 1).find("differ by 100.0 m in plan from"), std::string::npos);
  EXPECT_NE(off(3, 4).find("differ by 5.00 m from what"), std::string::npos);
}

TEST(FindingWords, AWrongCheckPointIsNamedWithWhatToDo) {
  EXPECT_EQ(
      what_of(finding_of(FindingCode::kCheckPoint, {ControlId{1}}, {{FigureName::kOffset, 3.21}}), named_block()),
      "Check point P1 contradicts the control points: its coordinates differ by 3.2 m from what they show. Look at "
      "its coordinates and at its measurements.");
}

// One of them is not "the first", and does not "hang together".
TEST(FindingWords, OneIsNotSeveral) {
  const auto words = [](FindingCode code, double count, std::vector<Subject> subjects) {
    return what_of(finding_of(code, std::move(subjects),
                              {{FigureName::kCount, count}, {FigureName::kOf, 5}, {FigureName::kLimit, 15}}),
                   named_block());
  };
  const Subject file = Subject::file("gnss.csv"), stranger = Subject::file("z.jpg");
  EXPECT_EQ(words(FindingCode::kImagesAlone, 1, {ImageId{1}}), "1 image could not be oriented: IMG_1.jpg.");
  EXPECT_EQ(words(FindingCode::kImagesAlone, 2, {ImageId{1}}), "2 images could not be oriented, the first: IMG_1.jpg.");
  EXPECT_EQ(words(FindingCode::kPartApart, 1, {ImageId{1}, ImageId{1}}),
            "1 image hangs together with no other: IMG_1.jpg.");
  EXPECT_EQ(words(FindingCode::kPartApart, 3, {ImageId{1}, ImageId{4}}),
            "3 images hang together but not with the block: IMG_1.jpg ... IMG_4.jpg.");
  EXPECT_EQ(words(FindingCode::kLooseGiven, 1, {ImageId{2}}),
            "Fewer than 15 tie points fit the pose of 1 image: IMG_2.jpg. Nothing here speaks for this pose.");
  EXPECT_EQ(words(FindingCode::kLooseGiven, 2, {ImageId{2}}),
            "Fewer than 15 tie points fit the poses of 2 images, the first: IMG_2.jpg. Nothing here speaks for these "
            "poses.");
  EXPECT_EQ(words(FindingCode::kPositionsOfOthers, 1, {file, stranger}),
            "1 of 5 images of gnss.csv is not among the images here: z.jpg.");
  EXPECT_EQ(words(FindingCode::kPositionsNotStated, 1, {file}),
            "1 of 5 images is not in gnss.csv and keeps what its header states.");
  EXPECT_EQ(words(FindingCode::kPositionsNotStated, 2, {file}),
            "2 of 5 images are not in gnss.csv and keep what their headers state.");
}

TEST(FindingWords, OfManyImagesTheFirstAreNamed) {
  std::vector<Subject> images;
  for (std::uint32_t i = 0; i < 9; ++i) images.emplace_back(ImageId{i});
  EXPECT_EQ(words_of(images, named_block()),
            "IMG_0.jpg, IMG_1.jpg, IMG_2.jpg, IMG_3.jpg, IMG_4.jpg, IMG_5.jpg and 3 more");
  images.resize(3);
  EXPECT_EQ(words_of(images, named_block()), "IMG_0.jpg, IMG_1.jpg and IMG_2.jpg");
}

TEST(FindingWords, InseparableUnknownsAreNamed) {
  Subject along(SubjectKind::kStrip, 0, Aspect::kShift, Subject::kAlongFlight);
  const Finding pair = finding_of(FindingCode::kInseparable, {Subject(CameraId{0}, Aspect::kTimeOffset), along},
                                  {{FigureName::kCorrelation, -0.99876}}, {RemedyCode::kFlyBack, RemedyCode::kGiveOne});
  EXPECT_EQ(sentence_of(pair, named_block()),
            "Two unknowns can hardly be separated: the time offset of the positions of FC6310 and the shift of "
            "positions along the flight of strip 1 (correlation -0.998). Fly strips in the opposite direction under "
            "one shift, or give one of them.");
}

TEST(FindingWords, DatumGaugeAndConditioning) {
  EXPECT_EQ(words_of(DatumSources{.control = true, .positions = true, .parts = 1}, 0),
            "control points, positions of images");
  EXPECT_EQ(words_of(DatumSources{.parts = 2}, 14),
            "free network (14 degrees of freedom kept by inner constraints, 2 unconnected parts)");
  EXPECT_TRUE(words_of(DatumSources{.geodetic = true}, 4).starts_with("partly measurements on the ground"));
  EXPECT_EQ(words_of(Gauge{.map = "EPSG:32633", .by_control = true, .positions = 8}),
            "in EPSG:32633, fixed by control points and the positions of 8 images");
  EXPECT_EQ(
      words_of(Gauge{.map = "M", .positions = 8, .position_use = PositionUse::kPlan, .level = LevelSource::kEdges}),
      "in M, fixed by the positions of 8 images in plan, levelled by the horizontal edges of the images");
  EXPECT_EQ(words_of(Gauge{.map = "M", .by_control = true, .positions = 1}),
            "in M, fixed by control points and the position of 1 image");
  EXPECT_EQ(words_of(Gauge{.map = "M", .positions = 5, .position_use = PositionUse::kOnLine}),
            "in M, fixed by the positions of 5 images on one line and the attitudes that the camera wrote");
  EXPECT_EQ(words_of(Gauge{.map = "M", .given_by = "model"}), "in M, as given by model");
  EXPECT_EQ(words_of(Gauge{.given_by = "model", .distances = 2}),
            "local gauge in metres, as given by model but for its scale by 2 distances");
  EXPECT_EQ(words_of(Gauge{.given_by = "model"}), "local gauge, as given by model");
  const Conditioning mixed{4,
                           {{Subject(CameraId{0}, Aspect::kParameter, Camera::kK1), 0.6},
                            {Subject(SubjectKind::kImage, Subject::kAll, Aspect::kAttitude), 0.3}}};
  EXPECT_EQ(words_of(mixed, named_block()), "k1 of camera FC6310 (60 %), the attitudes of the images (30 %)");
}

TEST(FindingJson, HoldsCodeSeveritySubjectsFiguresAndSentence) {
  const Finding finding =
      finding_of(FindingCode::kPositionHeights, {ControlId{1}, Subject(CameraId{0}, Aspect::kParameter, Camera::kK1)},
                 {{FigureName::kUp, -73.14}}, {OptionName{"gps_heights", "import"}});
  const auto json = finding_json(finding, named_block());
  EXPECT_EQ(json.at("code"), "position_heights");
  EXPECT_EQ(json.at("severity"), "wrong");
  EXPECT_EQ(json.at("subjects").at(0).dump(), R"({"kind":"control_point","name":"P1"})");
  EXPECT_EQ(json.at("subjects").at(1).dump(), R"({"kind":"camera","name":"FC6310","aspect":"parameter","axis":"k1"})");
  EXPECT_EQ(json.at("figures").at(0).dump(), R"({"name":"up_m","value":-73.14,"unit":"m"})");
  EXPECT_EQ(json.at("remedies").at(0).at("option").at("field"), "gps_heights");
  EXPECT_NE(json.at("what").get<std::string>().find("73.1 m below the control heights"), std::string::npos);
  EXPECT_EQ(json.at("remedy"), "See option gps_heights.");
}

}  // namespace
}  // namespace collinea
