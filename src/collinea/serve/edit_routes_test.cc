// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/edit_routes.h"

#include "collinea/edit/test_edits.h"
#include "collinea/serve/test_server.h"
#include "collinea/store/sqlite.h"

namespace collinea {
namespace {

using nlohmann::json;
using testing::Answer;
using testing::Connection;

class EditRoutes : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    ASSERT_TRUE(
        ProjectStore::open(village()).and_then([](ProjectStore store) { return store.write_setup(setup_to_edit()); }));
    edits_ = project() + "/edits";
  }
  [[nodiscard]] std::filesystem::path village() const { return folder_ / "village"; }
  Answer edit(const json& command) { return post(edits_, json{{"command", command}}.dump()); }
  json read(const std::string& query = "") { return json::parse(fetch(edits_ + query).body); }
  [[nodiscard]] std::size_t marks() const {
    return ProjectStore::open_to_read(village())->read_setup()->control_observations.size();
  }
  std::string edits_;
};

TEST_F(EditRoutes, EditsAreMadeUndoneAndRead) {
  EXPECT_EQ(read(), json::parse(R"({"number":0,"undo":null,"redo":null,"entries":[],"left_out":0})"));
  const std::size_t before = marks();
  const Answer made = edit({"mark", "B", "photo 0.jpg", "1200.31", "800.2", "0.05"});
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(json::parse(made.body), json({{"number", 1}}));
  EXPECT_EQ(marks(), before + 1);
  ASSERT_EQ(json::parse(edit({"role", "B", "check"}).body).at("number"), 2);
  ASSERT_EQ(json::parse(edit({"undo"}).body).at("number"), 3);
  const json all = read();
  EXPECT_EQ(all.at("number"), 3);
  EXPECT_EQ(all.at("undo"), "mark B \"sub/photo 0.jpg\" 1200.31 800.2 0.05");
  EXPECT_EQ(all.at("redo"), "role B check");
  ASSERT_EQ(all.at("entries").size(), 3u);
  EXPECT_EQ(all.at("entries")[1].at("command"), json({"role", "B", "check"}));
  EXPECT_EQ(all.at("entries")[1].at("undone"), true);
  EXPECT_EQ(all.at("entries")[2].at("command"), json({"undo"}));
  // What was undone since comes again.
  const json since = read("?since=2");
  ASSERT_EQ(since.at("entries").size(), 2u);
  EXPECT_EQ(since.at("entries")[0].at("number"), 2);
  EXPECT_TRUE(read("?since=3").at("entries").empty());
}

TEST_F(EditRoutes, TheCloudComesWithItsEditsInForce) {
  const std::string cloud = project() + "/cloud";
  EXPECT_EQ(json::parse(fetch(cloud).body), json::parse(R"({"file":null,"other":null,"regions":[]})"));
  std::filesystem::create_directories(village() / "products");
  ASSERT_TRUE(write_file(village() / "products/cloud.las", "LASF"));
  ASSERT_TRUE(write_file(village() / "products/cloud.copc.laz", "LASF"));
  ASSERT_EQ(edit({"classify", "6", "-", "12.5", "0", "0", "10", "0", "10", "5"}).status, 200);
  ASSERT_EQ(edit({"cut", "1", "2", "0", "0", "10", "0", "10", "5"}).status, 200);
  ASSERT_EQ(edit({"undo"}).status, 200);
  EXPECT_EQ(json::parse(fetch(cloud).body),
            json::parse(R"({"file":"products/cloud.copc.laz","other":"products/cloud.las","regions":[
              {"action":"classify","class":6,"ring":[[0,0],[10,0],[10,5]],"low_m":null,"high_m":12.5}]})"));
  EXPECT_EQ(post(cloud, "{}").status, 405);
}

TEST_F(EditRoutes, WhatOtherProgramsAppendIsReadAndCarriedOn) {
  ASSERT_EQ(edit({"role", "B", "check"}).status, 200);
  Journal journal(village());
  const std::vector<Edit> edits = {RemovePoint{"B"}};
  ASSERT_TRUE(make_edits(village(), journal, edits));
  EXPECT_EQ(read().at("undo"), "remove B");
  EXPECT_EQ(json::parse(edit({"undo"}).body).at("number"), 3);
}

TEST_F(EditRoutes, WhatIsWrongIsSaidAndMakesNothing) {
  for (const json& wrong :
       {json(nullptr), json("undo"), json::array(), json({"paint"}), json({"mark", "B"}), json({1, 2}),
        json({{"undo"}}), json({"undo"}), json({"mark", "B", "photo 0.jpg", "4001", "2"}),
        json({"mark", std::string(501, 'x'), "photo 0.jpg", "1", "2"}),
        json({"mark", "B", std::string("photo 0.jpg\0", 12), "1", "2"})}) {
    const Answer answer = edit(wrong);
    EXPECT_EQ(answer.status, 400) << wrong;
    EXPECT_TRUE(json::parse(answer.body).at("error").is_string());
  }
  EXPECT_EQ(edit({"mark", "NONE", "photo 0.jpg", "1", "2"}).status, 404);
  EXPECT_EQ(edit({"mark", "B", "../photo 0.jpg/..", "1", "2"}).status, 404);
  for (const char* body : {"", "{", "[]", "{}", "{\"command\":[\"\xff\"]}"})
    EXPECT_EQ(post(edits_, body).status, 400) << body;
  EXPECT_EQ(post(edits_, "{\"command\":" + std::string(5000, '[') + std::string(5000, ']') + "}").status, 400);
  EXPECT_EQ(post(edits_, "{\"command\":[\"" + std::string(600'000, 'x') + "\"]}").status, 413);
  EXPECT_EQ(post(edits_, R"({"command":["undo"]})", "text/plain").status, 415);  // as a form of another site could
  EXPECT_EQ(fetch(edits_ + "?since=-1").status, 400);
  EXPECT_EQ(fetch(edits_ + "/1").status, 404);
  EXPECT_EQ(fetch("/api/projects/0/edits").status, 404);
  EXPECT_FALSE(std::filesystem::exists(village() / "journal.jsonl") &&
               std::filesystem::file_size(village() / "journal.jsonl") > 0);
}

TEST_F(EditRoutes, ABrokenJournalIsNamed) {
  ASSERT_TRUE(write_file(village() / "journal.jsonl", "{}\n"));
  const Answer answer = fetch(edits_);
  EXPECT_EQ(answer.status, 422);
  EXPECT_NE(answer.body.find("journal.jsonl: line 1"), std::string::npos) << answer.body;
  EXPECT_EQ(edit({"role", "B", "check"}).status, 422);
}

TEST_F(EditRoutes, ManyClientsEditInOneOrder) {
  constexpr int kClients = 4, kEdits = 10;
  const std::string first = cookie();
  std::vector<std::vector<int>> numbers(kClients);
  {
    std::vector<std::jthread> clients;
    for (int c = 0; c < kClients; ++c)
      clients.emplace_back([&, c] {
        for (int i = 0; i < kEdits; ++i) {
          const Answer made = edit({"mark", "B", "photo 0.jpg", std::to_string(c), std::to_string(i)});
          ASSERT_EQ(made.status, 200) << made.body;
          numbers[static_cast<std::size_t>(c)].push_back(json::parse(made.body).at("number"));
        }
      });
  }
  std::set<int> all;
  for (const std::vector<int>& of_client : numbers) {
    EXPECT_TRUE(std::is_sorted(of_client.begin(), of_client.end()));
    all.insert(of_client.begin(), of_client.end());
  }
  EXPECT_EQ(all.size(), std::size_t{kClients * kEdits});
  EXPECT_EQ(*all.rbegin(), kClients * kEdits);
}

// Of every kind, in an order of chance: what the page reads and the fingerprint of the setup are as before when all is
// undone, and as after when all is redone, also where the server or the browser began anew in between.
TEST_F(EditRoutes, TwoHundredOfAllKindsAreUndoneAndRedoneAlsoAfterARestart) {
  const auto state = [&] {
    std::string text = std::to_string(ProjectStore::open_to_read(village())->setup_hash().value());
    for (const char* what : {"/control", "/work", "/drawing", "/cloud"}) {
      const Answer answer = fetch(project() + what);
      EXPECT_EQ(answer.status, 200) << what << answer.body;
      text += answer.body;
    }
    return text;
  };
  const auto repeat = [&](const char* word, int times) {
    for (int i = 0; i < times; ++i) ASSERT_EQ(edit({word}).status, 200) << word << i;
  };
  const auto restart = [&] {
    stop();
    start({});
  };
  Random random(5);
  std::set<std::string> kinds;
  const std::string before = state();
  std::string half;
  for (int made = 0; made < 200;) {
    const auto words = random.below(2) == 0 ? any_command(random) : any_work(random);
    if (edit(words).status != 200) continue;
    kinds.insert(words[0]);
    if (++made == 100) half = state();
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<Edit> - 2) << "all but undo and redo";
  const std::string after = state();
  repeat("undo", 100);
  EXPECT_EQ(state(), half);
  restart();
  EXPECT_EQ(state(), half);
  repeat("undo", 100);
  EXPECT_EQ(state(), before);
  EXPECT_EQ(edit({"undo"}).status, 400);
  restart();
  EXPECT_EQ(state(), before);
  repeat("redo", 100);
  EXPECT_EQ(state(), half);
  restart();
  repeat("redo", 100);
  EXPECT_EQ(state(), after);
  EXPECT_EQ(edit({"redo"}).status, 400);
  restart();
  EXPECT_EQ(state(), after);
}

// RFC 6455, 1.3.
constexpr const char* kUpgrade =
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

// The number of the next message that has one; jobs come between.
int next_number(Connection& events, const std::string& project) {
  while (const auto message = testing::read_message(events)) {
    const json changes = json::parse(*message);
    if (!changes.contains("edits")) continue;
    EXPECT_EQ(changes.at("edits").size(), 1u);
    EXPECT_TRUE(project.ends_with(changes.at("edits")[0].at("project").get<std::string>()));
    return changes.at("edits")[0].at("number");
  }
  return -1;
}

TEST_F(EditRoutes, EventsSayThatAJournalGrewInWhicheverProgram) {
  Connection events(port());
  events.send(head("GET", "/api/events") + "Origin: http://" + host() + "\r\n" + kUpgrade);
  ASSERT_EQ(events.read_answer(false).value().status, 101);
  EXPECT_FALSE(json::parse(testing::read_message(events).value_or("{}")).contains("edits"));
  ASSERT_EQ(edit({"role", "B", "check"}).status, 200);
  EXPECT_EQ(next_number(events, project()), 1);
  Journal journal(village());
  const std::vector<Edit> edits = {RemovePoint{"B"}};
  ASSERT_TRUE(make_edits(village(), journal, edits));  // as a command would
  EXPECT_EQ(next_number(events, project()), 2);
  // Who comes later learns where the journal is.
  Connection later(port());
  later.send(head("GET", "/api/events") + "Origin: http://" + host() + "\r\n" + kUpgrade);
  ASSERT_EQ(later.read_answer(false).value().status, 101);
  EXPECT_EQ(next_number(later, project()), 2);
}

TEST_F(EditRoutes, WhatWaitsForTheDatabaseIsTakenInOnceItIsFree) {
  const std::size_t before = marks();
  {
    auto writer = sqlite::Database::open(village() / "block.db").value();
    const auto busy = sqlite::Transaction::begin(writer);
    ASSERT_TRUE(busy);
    ASSERT_EQ(edit({"mark", "B", "photo 0.jpg", "1", "2"}).status, 200);
  }
  EXPECT_EQ(marks(), before);
  // Looked at as an open page does, until it is there: the test would hang, not pass, otherwise.
  for (std::uint64_t change = 0; marks() == before;) change = site_->journals->since(change, site_->roots).change;
  EXPECT_EQ(marks(), before + 1);
}

}  // namespace
}  // namespace collinea
