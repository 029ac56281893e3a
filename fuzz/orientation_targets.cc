// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/opk.h"
#include "sound.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

constexpr const char *kTextFiles[] = {"cameras.txt", "images.txt", "points3D.txt"},
                     *kBinaryFiles[] = {"cameras.bin", "images.bin", "points3D.bin"},
                     *kBundlerFiles[] = {"bundle.out", "list.txt"};

// Two nadir images and two points seen by both.
Block small_block() {
  Block block;
  Camera camera = ideal_camera(1000, 1200, 800);
  camera.params[Camera::kK1] = -0.05;
  block.cameras[{0}] = camera;
  for (std::uint32_t i = 0; i < 2; ++i) {
    Image image;
    image.file = "flight 1/image" + std::to_string(i) + ".jpg";
    image.camera = {0};
    block.images[{i}] = image;
    const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{1.0 + i, -2.0, 30.0 * i});
    set_pose(block, {i}, {rotation, -(rotation * Eigen::Vector3d(20.0 * i, 5, 100))});
  }
  for (std::uint32_t p = 0; p < 2; ++p) {
    const Eigen::Vector3d position(5.0 + p, 7, p);
    block.points[{p}] = {position, {std::uint8_t(p), 7, 255}};
    for (const auto& [id, pose] : oriented_images(block)) {
      Observation o;
      o.image = id;
      o.point = {p};
      o.pixel = project(camera, pose * position).value();
      block.observations.push_back(o);
    }
  }
  return block;
}

template <std::size_t N>
std::string seed(const std::filesystem::path& where, const char* const (&names)[N]) {
  std::string all;
  for (std::size_t i = 0; i < N; ++i) all += (i ? std::string(kCut) : "") + bytes_of(where / names[i]);
  return all;
}

// The parts of an input as the files of a folder.
template <std::size_t N>
std::filesystem::path unpacked(std::string_view bytes, const std::string& folder_name, const char* const (&names)[N]) {
  std::filesystem::create_directories(folder() / folder_name);
  const auto parts = parts_of(bytes);
  for (std::size_t i = 0; i < N; ++i)
    (void)file_of(i < parts.size() ? parts[i] : std::string_view{}, folder_name + "/" + names[i]);
  return folder() / folder_name;
}

bool accepted(const Result<Block>& block) {
  if (block) check_sound(*block);
  return block.has_value();
}

bool accepts_colmap_text(std::string_view bytes) {
  return accepted(read_colmap(unpacked(bytes, "colmap_text", kTextFiles)));
}

bool accepts_colmap_binary(std::string_view bytes) {
  return accepted(read_colmap(unpacked(bytes, "colmap_binary", kBinaryFiles)));
}

bool accepts_bundler(std::string_view bytes) {
  const auto size_of = [](const std::string&) -> Result<ImageSize> { return ImageSize{1200, 800}; };
  return accepted(read_bundler(unpacked(bytes, "bundler", kBundlerFiles), size_of));
}

bool accepts_opk(std::string_view bytes) {
  const auto rows = read_opk(file_of(bytes, "opk.txt"));
  static const Block block = small_block();
  return rows && poses_of(*rows, block).has_value();
}

}  // namespace

std::vector<Target> orientation_targets() {
  const Block block = small_block();
  const std::filesystem::path written = folder() / "seeds";
  std::filesystem::create_directories(written);
  (void)write_colmap(written, block, ColmapEncoding::kText);
  (void)write_colmap(written, block, ColmapEncoding::kBinary);
  (void)write_bundler(written, block);
  (void)write_opk(written / "opk.txt", block);
  return {{"colmap_text", accepts_colmap_text, {seed(written, kTextFiles)}},
          {"colmap_binary", accepts_colmap_binary, {seed(written, kBinaryFiles)}},
          {"bundler", accepts_bundler, {seed(written, kBundlerFiles)}},
          {"opk", accepts_opk, {bytes_of(written / "opk.txt")}}};
}

}  // namespace collinea::fuzz
