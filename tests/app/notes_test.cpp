// Points and distances a walker sets: pressing, undoing, and the file that keeps them.

#include "app/notes.h"

#include "scene/errors.h"
#include "tests/app/refused_lock.h"
#include "tests/repetitions.h"
#include "tests/scene/scratch_folder.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

namespace app {
namespace {

using nlohmann::json;
using scene::bytesOfFile;
using scene::Failure;
using scene::failureOf;

const char* const kTime = "2026-10-02T08:32:22Z";

scene::Pick at(double x, double y, double z, bool isSeen = true) {
    return {{x, y, z}, std::nullopt, 1, isSeen};
}

TEST(Noting, EachPressSetsAPointAndTwoADistance) {
    Noting noting = press({}, NoteMode::points, at(1, 2, 3), kTime);
    ASSERT_EQ(noting.notes.list.size(), 1u);
    EXPECT_EQ(noting.notes.list[0].label, "P1");
    EXPECT_EQ(noting.notes.list[0].from, glm::dvec3(1, 2, 3));
    noting = press(noting, NoteMode::distances, at(0, 0, 0), kTime);
    EXPECT_EQ(noting.notes.list.size(), 1u) << "only its start";
    EXPECT_EQ(noting.start, glm::dvec3(0));
    noting = press(noting, NoteMode::distances, at(1.2, 0.5, 0), kTime);
    ASSERT_EQ(noting.notes.list.size(), 2u);
    EXPECT_FALSE(noting.start);
    EXPECT_EQ(noting.notes.list[1].label, "D2 1.300 m");
    EXPECT_EQ(noting.notes.list[1].fields.at("distance_m"), 1.3);
    EXPECT_EQ(noting.notes.list[1].fields.at("made"), kTime);
    // Another mode in between forgets the start.
    noting = press(noting, NoteMode::distances, at(7, 7, 7), kTime);
    noting = press(noting, NoteMode::points, at(8, 8, 8), kTime);
    EXPECT_FALSE(noting.start);
    EXPECT_EQ(noting.notes.list.back().label, "P3");
}

TEST(Noting, WhatIsKnownSaysHowExactly) {
    const HowExactly howExactly = [](const glm::dvec3& place, const std::optional<glm::dvec3>& other) {
        return place.x < 5 ? std::optional(other ? 0.02 : 0.01) : std::nullopt;
    };
    Noting noting = press({}, NoteMode::points, at(1, 0, 0), kTime, howExactly);
    noting = press(noting, NoteMode::points, at(6, 0, 0), kTime, howExactly);
    noting = press(noting, NoteMode::distances, at(1, 0, 0), kTime, howExactly);
    noting = press(noting, NoteMode::distances, at(3, 0, 0), kTime, howExactly);
    ASSERT_EQ(noting.notes.list.size(), 3u);
    EXPECT_EQ(noting.notes.list[0].fields.at("known_to_m"), 0.01);
    EXPECT_FALSE(noting.notes.list[1].fields.contains("known_to_m"));
    EXPECT_EQ(noting.notes.list[2].fields.at("known_to_m"), 0.02);
    EXPECT_EQ(noting.notes.list[2].label, "D3 2.000 m +-0.020");
    noting = press(noting, NoteMode::points, at(1, 0, 0), kTime,
                   [](const glm::dvec3&, const std::optional<glm::dvec3>&) { return 1e-6; });
    EXPECT_EQ(noting.notes.list[3].fields.at("known_to_m"), 0.001) << "more than is shown is not claimed";
}

TEST(Noting, WhatNobodySawIsNotMeasured) {
    EXPECT_TRUE(press({}, NoteMode::points, at(1, 2, 3, false), kTime).notes.list.empty());
    Noting noting = press({}, NoteMode::distances, at(1, 2, 3), kTime);
    noting = press(noting, NoteMode::distances, at(4, 5, 6, false), kTime);
    EXPECT_TRUE(noting.notes.list.empty());
    EXPECT_EQ(noting.start, glm::dvec3(1, 2, 3)) << "still waits for its end";
}

TEST(Noting, UndoTakesBackInTheOrderOfTimeButNothingOfEarlierWalks) {
    Noting noting = press({}, NoteMode::points, at(0, 0, 0), kTime);
    noting.older = 1;
    noting = press(noting, NoteMode::points, at(1, 0, 0), kTime);
    noting = press(noting, NoteMode::distances, at(2, 0, 0), kTime);
    noting = press(noting, NoteMode::distances, at(3, 0, 0), kTime);
    noting = press(noting, NoteMode::distances, at(4, 0, 0), kTime);
    noting = undo(noting);
    EXPECT_FALSE(noting.start);
    EXPECT_EQ(noting.notes.list.size(), 3u);
    noting = undo(noting);
    EXPECT_EQ(noting.notes.list.back().label, "P2");
    for (int i = 0; i < 3; ++i)
        noting = undo(noting);
    ASSERT_EQ(noting.notes.list.size(), 1u);
    EXPECT_EQ(noting.notes.list[0].label, "P1");
    EXPECT_EQ(press(noting, NoteMode::points, at(9, 0, 0), kTime).notes.list.back().label, "P2");
}

class NotesOnDisk : public testing::Test {
  protected:
    std::filesystem::path file() const { return scratch_ / "notes.json"; }
    Notes someNotes() const {
        Noting noting = press({}, NoteMode::points, at(412345.678901234, -5.4e6 / 7, 1e-300), kTime);
        noting = press(noting, NoteMode::distances, at(1.0 / 3, 2, 3), kTime);
        return press(noting, NoteMode::distances, at(1, 2, 3), kTime).notes;
    }
    scene::ScratchFolder scratch_;
};

TEST_F(NotesOnDisk, ComeBackToTheLastBit) {
    const Notes notes = someNotes();
    NotesFile(scratch_.path()).write(notes);
    const Notes again = NotesFile(scratch_.path()).read();
    ASSERT_EQ(again.list.size(), notes.list.size());
    for (std::size_t i = 0; i < notes.list.size(); ++i) {
        EXPECT_EQ(again.list[i].kind, notes.list[i].kind);
        EXPECT_EQ(again.list[i].number, notes.list[i].number);
        EXPECT_EQ(again.list[i].label, notes.list[i].label);
        EXPECT_EQ(again.list[i].from, notes.list[i].from);
        EXPECT_EQ(again.list[i].to, notes.list[i].to);
        EXPECT_EQ(again.list[i].fields, notes.list[i].fields);
    }
    EXPECT_EQ(scratch_.fileCount(), 1u) << "nothing temporary is left";
    EXPECT_EQ(textOf(again), bytesOfFile(file()));
}

TEST_F(NotesOnDisk, NoFileIsNoNotes) {
    EXPECT_TRUE(NotesFile(scratch_.path()).read().list.empty());
    EXPECT_EQ(scratch_.fileCount(), 0u) << "reading leaves none behind";
}

TEST_F(NotesOnDisk, WhatThisVersionDoesNotKnowSurvives) {
    const json written{
        {"format", "revisit notes"},
        {"version", 1},
        {"unit", "m"},
        {"author", "somebody"},
        {"notes",
         {{{"number", 4}, {"kind", "point"}, {"label", "front door"}, {"position", {1, 2, 3}}, {"colour", "red"}},
          {{"number", 9}, {"kind", "area"}, {"corners", {{1, 2, 3}, {4, 5, 6}}}}}}};
    scene::writeFile(file(), written.dump());
    NotesFile notesFile(scratch_.path());
    Noting noting{notesFile.read(), 0, {}};
    EXPECT_EQ(noting.notes.list[0].label, "front door");
    noting = press(noting, NoteMode::points, at(0, 0, 0), kTime);
    EXPECT_EQ(noting.notes.list.back().label, "P10");
    notesFile.write(noting.notes);
    json again = json::parse(bytesOfFile(file()));
    ASSERT_EQ(again.at("notes").size(), 3u);
    again["notes"].erase(2);
    EXPECT_EQ(again, written);
}

TEST_F(NotesOnDisk, ABrokenOrForeignFileIsRefusedInOneLineAndLeftAlone) {
    const std::string good = textOf(someNotes());
    const auto changed = [&](const char* pointer, const json& value) {
        json root = json::parse(good);
        root[json::json_pointer(pointer)] = value;
        return root.dump();
    };
    const std::vector<std::string> bad{
        "",
        "{",
        "[]",
        "null",
        "{\"format\": \"other\"}",
        good.substr(0, good.size() / 2),
        changed("/format", 3),
        changed("/version", 2),
        changed("/unit", "ft"),
        changed("/notes", 5),
        changed("/notes/0", 5),
        changed("/notes/0/number", 0),
        changed("/notes/0/number", 1.5),
        changed("/notes/0/number", 1e300),
        changed("/notes/0/kind", nullptr),
        changed("/notes/0/label", 5),
        changed("/notes/0/position", {1, 2}),
        changed("/notes/0/position", {1, 2, "3"}),
        changed("/notes/1/to", nullptr),
        "{\"format\": \"revisit notes\", \"version\": 1, \"unit\": \"m\", \"notes\": [{\"number\": 1, \"kind\": "
        "\"point\", \"label\": \"P1\", \"position\": [1e999, 0, 0]}]}"};
    for (const std::string& text : bad) {
        scene::writeFile(file(), text);
        NotesFile notesFile(scratch_.path());
        const std::string said = failureOf<Failure>([&] { notesFile.read(); });
        EXPECT_NE(said.find("notes.json"), std::string::npos) << text;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        EXPECT_NE(failureOf<Failure>([&] { notesFile.write(someNotes()); }), "") << "it has never been read";
        EXPECT_EQ(bytesOfFile(file()), text);
    }
    std::filesystem::remove(file());
    std::filesystem::create_directory(file());
    EXPECT_NE(failureOf<Failure>([&] { NotesFile(scratch_.path()).read(); }), "");
}

TEST_F(NotesOnDisk, WhatAnotherProgramWroteMeanwhileIsNotOverwritten) {
    NotesFile mine(scratch_.path()), theirs(scratch_.path());
    mine.read(), theirs.read();
    theirs.write(someNotes());
    const std::string said = failureOf<Failure>([&] { mine.write({}); });
    EXPECT_NE(said.find("another program"), std::string::npos) << said;
    EXPECT_EQ(bytesOfFile(file()), textOf(someNotes()));
    theirs.write({}); // who wrote last goes on
    mine.read();
    mine.write(someNotes());
    std::filesystem::remove(file());
    EXPECT_NE(failureOf<Failure>([&] { mine.write({}); }), "") << "that it is gone is a change, too";
}

TEST_F(NotesOnDisk, WhoReadsMeanwhileSeesAllOrNothing) {
    // A writer in another process, of files of ever changing length; each read finds a whole one.
    const pid_t writer = fork();
    if (writer == 0) {
        NotesFile file(scratch_.path());
        for (int i = 0; i < tests::repetitions(300); ++i) {
            Noting noting;
            for (int k = 0; k < (i * 37) % 100; ++k)
                noting = press(noting, NoteMode::points, at(k, i, 0), kTime);
            file.write(noting.notes);
        }
        _exit(0);
    }
    int status = 0, reads = 0;
    while (waitpid(writer, &status, WNOHANG) == 0) {
        EXPECT_NO_THROW(NotesFile(scratch_.path()).read());
        ++reads;
    }
    EXPECT_EQ(status, 0);
    EXPECT_GT(reads, 0);
}

TEST_F(NotesOnDisk, OfTwoWhoWriteAtOnceOneIsToldAndTheFileIsWhole) {
    for (int round = 0; round < 20; ++round) {
        NotesFile a(scratch_.path()), b(scratch_.path());
        const Noting noting{a.read(), 0, {}};
        b.read();
        const Notes forA = press(noting, NoteMode::points, at(1, 0, round), kTime).notes;
        const Notes forB = press(noting, NoteMode::points, at(2, 0, round), kTime).notes;
        std::string saidA, saidB;
        std::thread other([&] { saidB = failureOf<Failure>([&] { b.write(forB); }); });
        saidA = failureOf<Failure>([&] { a.write(forA); });
        other.join();
        EXPECT_NE(saidA.empty(), saidB.empty()) << "exactly one was first";
        EXPECT_EQ(NotesFile(scratch_.path()).read().list.back().from.x, saidA.empty() ? 1 : 2);
    }
}

TEST_F(NotesOnDisk, AFolderThatIsGoneIsSaidInOneLine) {
    NotesFile file(scratch_ / "gone");
    EXPECT_TRUE(file.read().list.empty());
    EXPECT_NE(failureOf<Failure>([&] { file.write(someNotes()); }), "");
}

TEST_F(NotesOnDisk, AreKeptWhereNothingCanBeLocked) {
    NotesFile mine(scratch_.path());
    mine.read();
    {
        const RefusedLock refused(EOPNOTSUPP);
        EXPECT_EQ(failureOf<Failure>([&] { mine.write(someNotes()); }), "");
    }
    EXPECT_EQ(NotesFile(scratch_.path()).read().list.size(), someNotes().list.size());
    const RefusedLock refused(EIO);
    const std::string said = failureOf<Failure>([&] { mine.write({}); });
    EXPECT_NE(said.find(std::string("cannot be locked (") + std::strerror(EIO) + "); "), std::string::npos) << said;
}

TEST(NoteLabels, SayKindNumberAndMetres) {
    EXPECT_EQ(labelOf(7, std::nullopt), "P7");
    EXPECT_EQ(labelOf(2, 1.2344), "D2 1.234 m");
    EXPECT_EQ(labelOf(2, 1.2344, 0.0126), "D2 1.234 m +-0.013");
    EXPECT_EQ(timeNow().size(), std::string(kTime).size());
}

} // namespace
} // namespace app
