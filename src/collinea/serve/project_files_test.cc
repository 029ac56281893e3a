// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/project_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Parts = std::vector<std::string>;

fs::path make_project(const fs::path& folder) {
  fs::create_directories(folder / "products" / "tiles");
  EXPECT_TRUE(write_file(folder / "project.json", "{}"));
  EXPECT_TRUE(write_file(folder / "products" / "dsm.tif", "0123456789"));
  EXPECT_TRUE(write_file(folder / "products" / "tiles" / "a b.tif", "tile"));
  EXPECT_TRUE(write_file(folder / "block.db", "database"));
  return folder;
}

bool opens(const fs::path& folder, const Parts& parts) { return OpenFile::in_project(folder, parts) != nullptr; }

TEST(ProjectFiles, ProjectsAreFoundOnceEach) {
  const TestFolder folder;
  make_project(folder / "two");
  make_project(folder / "one");
  fs::create_directories(folder / "no project");
  fs::create_directory_symlink(folder / "one", folder / "same");
  const fs::path roots[] = {folder / "", folder / "one", folder / "missing"};
  const auto projects = find_projects(roots);
  ASSERT_EQ(projects.size(), 2u);
  EXPECT_EQ(projects[0].name, "one");
  EXPECT_EQ(projects[1].name, "two");
  EXPECT_NE(projects[0].id, projects[1].id);
  EXPECT_EQ(find_project(roots, projects[1].id)->folder, fs::canonical(folder / "two"));
  EXPECT_FALSE(find_project(roots, "one"));
}

TEST(ProjectFiles, PartsAreReadAnywhere) {
  const TestFolder folder;
  const auto file = OpenFile::in_project(make_project(folder / "p"), Parts{"products", "dsm.tif"});
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size(), 10u);
  std::string text(4, ' ');
  EXPECT_EQ(file->read_at(3, text), 4u);
  EXPECT_EQ(text, "3456");
  EXPECT_EQ(file->read_at(8, text), 2u);
  EXPECT_EQ(file->read_at(10, text), 0u);
}

TEST(ProjectFiles, NothingOutsideIsOpened) {
  const TestFolder folder;
  const fs::path project = make_project(folder / "p");
  make_project(folder / "p2");
  ASSERT_TRUE(write_file(folder / "secret", "secret"));
  fs::create_symlink(folder / "secret", project / "products" / "file_outside");
  fs::create_directory_symlink(folder / "", project / "products" / "folder_outside");
  fs::create_directory_symlink(folder / "p2" / "products", project / "report");
  fs::create_symlink("dsm.tif", project / "products" / "file_inside");
  ASSERT_EQ(::mkfifo((project / "products" / "pipe").c_str(), 0600), 0);

  EXPECT_TRUE(opens(project, {"products", "tiles", "a b.tif"}));
  EXPECT_TRUE(opens(project, {"products", "file_inside"}));
  const std::vector<Parts> refused = {{},
                                      {"products"},
                                      {"block.db"},
                                      {"project.json"},
                                      {"products", "missing"},
                                      {"products", "tiles"},
                                      {"products", ""},
                                      {"products", "."},
                                      {"products", "..", "block.db"},
                                      {"products", "../block.db"},
                                      {"products", "..", "products", "dsm.tif"},
                                      {"..", "secret"},
                                      {"products", "tiles/a b.tif"},
                                      {"products", std::string("dsm.tif\0", 8)},
                                      {"products", "file_outside"},
                                      {"products", "folder_outside", "secret"},
                                      {"report", "dsm.tif"},
                                      {"products", "pipe"},
                                      {"", "etc", "passwd"}};
  for (const Parts& parts : refused) EXPECT_FALSE(opens(project, parts)) << ::testing::PrintToString(parts);
  EXPECT_FALSE(opens(folder / "missing", {"products", "dsm.tif"}));
}

// "p2" begins with the name of "p".
TEST(ProjectFiles, ANeighbourIsOutside) {
  const TestFolder folder;
  const fs::path project = make_project(folder / "p");
  make_project(folder / "p2");
  fs::create_symlink(folder / "p2" / "products" / "dsm.tif", project / "products" / "neighbour");
  EXPECT_FALSE(opens(project, {"products", "neighbour"}));
}

TEST(ProjectFiles, TheTagChangesWithTheFile) {
  const TestFolder folder;
  const fs::path project = make_project(folder / "p");
  const Parts parts{"products", "dsm.tif"};
  const std::string before = OpenFile::in_project(project, parts)->tag();
  EXPECT_EQ(OpenFile::in_project(project, parts)->tag(), before);
  ASSERT_TRUE(write_file(project / "products" / "dsm.tif", "other"));
  EXPECT_NE(OpenFile::in_project(project, parts)->tag(), before);
}

TEST(ProjectFiles, WhatIsListedOpens) {
  const TestFolder folder;
  const fs::path project = make_project(folder / "p");
  fs::create_symlink("/etc/passwd", project / "products" / "outside");
  fs::create_directory_symlink("/etc", project / "report");
  const auto files = files_of(project);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].path, "products/dsm.tif");
  EXPECT_EQ(files[0].bytes, 10u);
  EXPECT_EQ(files[1].path, "products/tiles/a b.tif");
  for (const ProjectFile& file : files) {
    Parts parts;
    for (const fs::path& part : fs::path(file.path)) parts.push_back(part.string());
    const auto open = OpenFile::in_project(project, parts);
    ASSERT_TRUE(open) << file.path;
    EXPECT_EQ(open->size(), file.bytes);
  }
  EXPECT_TRUE(files_of(folder / "missing").empty());
}

// What a project keeps beside its products is not served by another name.
TEST(ProjectFiles, LinksOutOfTheServedFoldersOpenNothing) {
  const TestFolder folder;
  const fs::path project = make_project(folder / "p");
  fs::create_directories(project / "work");
  ASSERT_TRUE(write_file(project / "work" / "tile", "tile"));
  fs::create_symlink("../block.db", project / "products" / "database");
  fs::create_directory_symlink("..", project / "products" / "up");
  fs::create_directory_symlink("work", project / "report");
  const std::vector<Parts> refused = {
      {"products", "database"}, {"products", "up", "block.db"}, {"products", "up", "work", "tile"}, {"report", "tile"}};
  for (const Parts& parts : refused) EXPECT_FALSE(opens(project, parts)) << ::testing::PrintToString(parts);
  EXPECT_EQ(files_of(project).size(), 2u);
}

}  // namespace
}  // namespace collinea
