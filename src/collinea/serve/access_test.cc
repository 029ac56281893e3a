// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/access.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

const ServerNames kLocal{.port = 8471};

TEST(Access, HostsOfThisMachine) {
  for (const char* own : {"127.0.0.1:8471", "localhost:8471", "LocalHost:8471", "[::1]:8471"})
    EXPECT_TRUE(is_own_host(own, kLocal)) << own;
  for (const char* foreign : {"", "evil.example:8471", "127.0.0.1", "127.0.0.1:80", "localhost:84710",
                              "localhost.evil.example:8471", "10.0.0.1:8471", ":8471", "127.0.0.1:8471:8471"})
    EXPECT_FALSE(is_own_host(foreign, kLocal)) << foreign;
}

// A name that another site has for this machine (DNS rebinding) is never one of digits.
TEST(Access, EveryAddressIsOwnWhereAllAreServed) {
  ServerNames names{.port = 8471, .hosts = {"station"}, .any_address = true};
  for (const char* own : {"10.0.0.1:8471", "[fe80::1]:8471", "station:8471"})
    EXPECT_TRUE(is_own_host(own, names)) << own;
  for (const char* foreign : {"evil.example:8471", "10.0.0.1.evil.example:8471", "face:8471", "[evil]:8471"})
    EXPECT_FALSE(is_own_host(foreign, names)) << foreign;
}

TEST(Access, OriginsOfThisServer) {
  EXPECT_TRUE(is_own_origin("", "localhost:8471"));
  EXPECT_TRUE(is_own_origin("http://localhost:8471", "localhost:8471"));
  for (const char* foreign : {"null", "http://localhost", "https://localhost:8471", "http://127.0.0.1:8471",
                              "http://evil.example", "http://localhost:8471.evil.example", "file://"})
    EXPECT_FALSE(is_own_origin(foreign, "localhost:8471")) << foreign;
}

TEST(Access, CookiesByName) {
  EXPECT_EQ(cookie_in("a=1; bc=2;c=3", "a"), "1");
  EXPECT_EQ(cookie_in("a=1; bc=2;c=3", "c"), "3");
  EXPECT_EQ(cookie_in("a=1; bc=2;c=3", "b"), "");
  EXPECT_EQ(cookie_in("", "a"), "");
  EXPECT_EQ(cookie_in("a", "a"), "");
}

TEST(Access, SecretsAreLongAndNew) {
  EXPECT_EQ(new_secret().size(), 64u);
  EXPECT_NE(new_secret(), new_secret());
  EXPECT_TRUE(is_same_secret("abc", "abc"));
  for (const char* other : {"", "ab", "abd", "abcd"}) EXPECT_FALSE(is_same_secret("abc", other)) << other;
}

TEST(Access, ALinkServesOnce) {
  Access access(kLocal);
  const std::string token = access.link().substr(std::string("/?token=").size());
  EXPECT_FALSE(access.exchange(""));
  EXPECT_FALSE(access.exchange(token.substr(1)));
  const auto cookie = access.exchange(token);
  ASSERT_TRUE(cookie);
  EXPECT_FALSE(access.exchange(token));
  EXPECT_NE(access.link(), "/?token=" + token);
  EXPECT_NE(cookie->find("; HttpOnly; SameSite=Strict"), std::string::npos);
  const std::string pair = cookie->substr(0, cookie->find(';'));
  EXPECT_EQ(pair.find(token), std::string::npos);  // what stands in a history opens nothing

  HttpRequest request{.method = "GET", .target = "/", .headers = {{"host", "localhost:8471"}}};
  EXPECT_EQ(access.refusal(request)->status, 401);
  request.headers["cookie"] = "other=1; " + pair;
  EXPECT_FALSE(access.refusal(request));
  request.headers["origin"] = "http://evil.example";
  EXPECT_EQ(access.refusal(request)->status, 403);
  request.headers["origin"] = "http://localhost:8471";
  EXPECT_FALSE(access.refusal(request));
  request.headers["host"] = "evil.example:8471";
  EXPECT_EQ(access.refusal(request)->status, 403);
}

}  // namespace
}  // namespace collinea
