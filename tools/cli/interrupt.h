// What ends the tools from outside: Ctrl-C, schedulers that want the machine back, terminals that
// close.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace pvol::cli {

/// From here on SIGINT, SIGTERM, SIGHUP, SIGUSR2 and SIGXCPU end the tool at once, whatever it is
/// doing: files that are half written are removed, one line on stderr tells in what it was
/// interrupted, and the process dies of the signal, so that shells and schedulers see it. SIGUSR1
/// ends nothing, nor does a reader of stderr or stdout that is gone. Signals that were ignored stay
/// so. SIGBUS, where a page of a mapped file is gone, ends the tool with a line that names the
/// file, and exit status 1. To be called once, in main, before there is another thread.
void watch_signals(const std::string& tool);

/// While one is there, the first signal only makes `interrupted` true, for the tool to save what it
/// has; a second one ends it. One within another changes nothing.
class SavesOnInterrupt {
 public:
  SavesOnInterrupt();
  ~SavesOnInterrupt();
  SavesOnInterrupt(const SavesOnInterrupt&) = delete;
  SavesOnInterrupt& operator=(const SavesOnInterrupt&) = delete;

 private:
  bool outermost_;
};

/// Once true, it stays so.
[[nodiscard]] bool interrupted();

/// Whether SIGUSR1 came since the last call, or since the outermost SavesOnInterrupt was made:
/// before that there is nothing to write.
[[nodiscard]] bool take_checkpoint_request();

/// While it is there, a signal that ends the tool calls `tell`, e.g. to print what is done, after
/// its own line. That happens on another thread, which `tell` may not keep waiting. There is one at
/// a time.
class TellsOnInterrupt {
 public:
  explicit TellsOnInterrupt(std::function<void()> tell);
  ~TellsOnInterrupt();
  TellsOnInterrupt(const TellsOnInterrupt&) = delete;
  TellsOnInterrupt& operator=(const TellsOnInterrupt&) = delete;

 private:
  std::function<void()> tell_;
};

/// Notes what the tool is doing, "reading cloud.vdb", for the message of an interruption; nothing
/// where it is empty.
void note_stage(const std::string& stage);

/// Notes how wide the line on the terminal is that a message would have to cover.
void note_line(std::size_t width);

/// Ends the tool by SIGPIPE where nobody reads its standard output any more, as in `tool | head
/// -1`.
void end_if_reader_left();

/// Does not return where a signal is about to end the tool: what fails meanwhile is no news.
void give_way_to_signal();

}  // namespace pvol::cli
