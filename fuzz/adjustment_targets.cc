// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/adjustment_file.h"
#include "collinea/io/bingo.h"
#include "collinea/io/dbat_script.h"
#include "collinea/io/patb.h"
#include "collinea/io/photomodeler.h"
#include "sound.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

const std::string kAdjustment =
    "collinea-adjustment 1\n# two images, one point\ngeoreference EPSG:32633 48.1 15.3 312.25\ncamera wide 4000 3000 "
    "brown\n"
    "parameter wide f 3600.5 free\nparameter wide k1 -0.02 0.01 -0.03\nimage \"left one.jpg\" wide   # a remark\n"
    "image b wide\npose \"left one.jpg\" 0 0 50 0 0 90 fixed\nposition b 10 0 - 0.5 0.5 -\ncontrol G1 1 2 3 0 0 -\n"
    "check \"a \"\"b\"\"\" 1 2 3 0.1 0.1 0.2\npoint 7 5 5 1\nmeasured_control b G1 100.5 200 0.3\n"
    "measured_tie b 7 1 2 0.5\nmeasured_tie \"left one.jpg\" 7 3 4 0.5\n";

const std::string kPhotomodeler =
    "Bundle of two photographs\n 0.0005 20 2000 1500\n 1.0 0.1 10.0 100.0 100.0 100.0 20.0 20.0 20.0\n"
    " 8.0 4.1 2.9 8.00 6.00 5e-3 -1e-4 1e-6 -6e-5 -3e-5\n 0.0 0.0 0.0 0.5 0.5 0.001 0.0001 0.0001 0.001 0.001\n"
    "   0 photos\\one.JPG\n   0 1.0 2.0 30.0 90.0 2.0 1.0\n   0 0.1 0.1 0.1 0.1 0.1 0.1\n\n"
    "   0 8.0 4.1 2.9 8.0 6.0 0 0 0 0 0\n   0 0 0 0 0 0 0 0 0 0 0\n   1 photos/two.JPG\n"
    "   1 5.0 2.0 30.0 0.0 0.0 0.0\n   1 0.1 0.1 0.1 0.1 0.1 0.1\n\n   1 8.0 4.1 2.9 8.0 6.0 0 0 0 0 0\n"
    "   1 0 0 0 0 0 0 0 0 0 0\n\n 1001 0.5 0.5 0.0 -1.7 -1.7 0.01\n\n 2 1.0 1.0 0.1 0.01 0.01 0.01\n\n"
    " 1 2 800.5 600.25 0.1 0.1\n 0 2 700 500 0.1 0.1\n 0 1001 900 700 0.2 0.2\n\n 1 1 2\n";

const std::string kScript = R"(<?xml version="1.0" encoding="UTF-8"?>
<document dbat_script_version="1.0.0">
  <c>Remarks may hold <!-- anything --> .</c>
  <input base_dir="$HERE">
    <ctrl_pts><file format="id,label,x,y,z,sxyz">1.txt</file></ctrl_pts>
    <images image_base_dir="$DBAT"><file format="id,path">2.txt</file></images>
    <prior_eo><file format="id,x,y,z,omega,phi,kappa" units="degrees">3.txt</file></prior_eo>
    <image_pts><file format="im,id,x,y" sxy="0.5">4.txt</file></image_pts>
    <cameras><camera>
      <name>test</name><unit>mm</unit><sensor>auto,6</sensor><image>2000,1500</image>
      <focal>8</focal><model>3</model><K>1e-3,0,0</K>
    </camera></cameras>
  </input>
  <operations>
    <operation min_rays="2">check_ray_count</operation>
    <operation><set_bundle_estimate_params>
      <io><all>true</all><skew>false</skew><K3>false</K3></io>
    </set_bundle_estimate_params></operation>
    <operation><set_datum ref_cam="1" ref_base="longest">depend</set_datum></operation>
    <operation>bundle_adjustment</operation>
  </operations>
</document>
)";

std::string dbat_seed() {
  const std::string cut(kCut);
  return kScript + cut + "# id, label, x, y, z, s\n1001, CP1, 0, 1, 0, 0.001\n1002,, 1, 1, 0, 0\n" + cut +
         " 1, data/one.JPG\n 2, data/two.JPG\n 3, three.JPG\n" + cut +
         "1, 0, 0, 10, 0, 0, 0\n2, 3, -4, 10, 0, 0, 0\n3, 1, 1, 9, 1, 2, 3\n" + cut +
         "2, 5, 100, 200\n1, 5, 110.5, 210\n1, 1001, 7, 8\n";
}

bool accepted(const Result<AdjustmentFile>& file) {
  if (file) check_sound(file->block);
  return file.has_value();
}

// The script, and the tables that it may name "1.txt" to "4.txt".
bool accepts_dbat(std::string_view bytes) {
  const auto parts = parts_of(bytes);
  for (std::size_t i = 1; i < 5; ++i)
    (void)file_of(i < parts.size() ? parts[i] : std::string_view{}, std::to_string(i) + ".txt");
  return accepted(read_dbat_script(file_of(parts[0], "script.xml")));
}

// The parts of one input, as the files of these names; the first is read.
template <class Read>
bool accepts_files(std::string_view bytes, std::initializer_list<const char*> names, Read&& read) {
  const auto parts = parts_of(bytes);
  std::filesystem::path first;
  std::size_t i = 0;
  for (const char* name : names) {
    const auto path = file_of(i < parts.size() ? parts[i] : std::string_view{}, name);
    if (i++ == 0) first = path;
  }
  return accepted(read(first));
}

std::string photo_seed(const char* head, const char* control, const char* names) {
  const std::string cut(kCut);
  return std::string("1 ") + head + "\n1 -1200.5 300\n3 10 20\n-99\n2 " + head + "\n1 900 310\n3 -2000 25\n-99\n" +
         cut + control + cut + names + cut + "ORIA 1 0 0 50 0.1 -0.2 100 0\n";
}

constexpr const char* kPhotoNames = "unit 4.4\nsigma 2\nimage 1 a b.jpg\ncontrol 1 check 0.01 0.01 inf G 1\n";

// What was read can be written, and that can be read again.
bool accepts_adjustment(std::string_view bytes) {
  const auto file = parse_adjustment_file(bytes);
  if (!accepted(file)) return false;
  const auto again = parse_adjustment_file(adjustment_file_text(*file));
  COLLINEA_CHECK(again && again->block.observations.size() == file->block.observations.size());
  return true;
}

}  // namespace

std::vector<Target> adjustment_targets() {
  return {{"adjustment", accepts_adjustment, {kAdjustment}},
          {"dbat", accepts_dbat, {dbat_seed()}},
          {"photomodeler",
           [](std::string_view bytes) { return is_photomodeler(bytes) && accepted(parse_photomodeler(bytes)); },
           {kPhotomodeler}},
          {"patb",
           [](std::string_view bytes) {
             return accepts_files(bytes, {"a.im", "a.con", "a.names"}, read_patb);
           },
           {photo_seed("15300", "1 10 20\n-99\n1 3\n-99\n", kPhotoNames)}},
          {"bingo",
           [](std::string_view bytes) {
             return accepts_files(bytes, {"image.dat", "geoin.dat", "names.dat", "itera.dat"}, read_bingo);
           },
           {photo_seed("C1", "CAPA C1 0 20 0.1 0\nCONT 1 10 20 3\nCHCK 3 1 2 3\n", kPhotoNames)}}};
}

}  // namespace collinea::fuzz
