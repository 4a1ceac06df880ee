// A list of a user's actions, which alabaster-view-player takes. One action a line; # begins a comment.
//
//   size W H                     the window's size in pixels, 1 to 16384
//   wait covered|converged|samples N|seconds S [SECONDS]   that many seconds at most (60); longer fails the script
//   drag BUTTON X0 Y0 X1 Y1      left, middle or right, over the picture; places are shares of it, y down
//   click X Y                    on the picture
//   wheel X Y N                  over the picture
//   key NAME                     a letter, space, escape, enter
//   press WIDGET                 a button, a box to tick or a tab
//   choose WIDGET ITEM           an item of a menu
//   slide WIDGET SHARE           a slider: 0 is its left end
//   type WIDGET TEXT             into a field or a slider
//   copy FROM TO                 a file in the place of another, as a program beside the window does
//   screenshot FILE.ppm          of the whole window
//   state                        prints a line of JSON
//   quit
//
// Words with spaces stand in double quotes.
#pragma once

#include <string>
#include <vector>

namespace alabaster::view {

struct ScriptAction {
  int line = 0;
  std::string name;
  std::vector<std::string> words;  // the arguments
  /// Argument `i` as a number: the reader has checked that it is one.
  double number(size_t i) const;
};

struct Script {
  std::vector<ScriptAction> actions;
  std::string problem;  // with its line; empty if the text is good
};

Script read_script(const std::string& text);

}  // namespace alabaster::view
