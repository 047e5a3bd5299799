# Read a recording in R: Rscript read_recording.R FILE. Needs jsonlite and openssl.
suppressPackageStartupMessages({library(jsonlite); library(openssl)})

# Returns the header, the events, and whether the session was closed properly.
read_recording <- function(path) {
  bytes <- readBin(path, "raw", file.size(path))
  ends <- which(bytes == as.raw(10))  # behind the last newline: a line that was never finished
  starts <- c(1, head(ends, -1) + 1)
  sealed <- mapply(function(from, to) rawToChar(bytes[from:(to - 1)]), starts, ends)
  Encoding(sealed) <- "UTF-8"
  pattern <- ',"chain":"([0-9a-f]{16})"\\}$'
  if (!all(grepl(pattern, sealed))) stop(path, ":", which(!grepl(pattern, sealed))[1], ": no chain")
  payloads <- sub(pattern, "}", sealed)
  chains <- substr(sealed, nchar(sealed) - 17, nchar(sealed) - 2)
  whole <- function(n) {  # the chain of line n is the hash of all payloads up to it
    text <- charToRaw(paste(payloads[seq_len(n)], collapse = ""))
    substr(as.character(sha256(text)), 1, 16) == chains[n]
  }
  if (!whole(length(payloads))) {
    first <- Position(Negate(whole), seq_along(payloads))
    stop(path, ":", first, ": this line was changed, or one before it")
  }
  records <- lapply(payloads, fromJSON, simplifyVector = FALSE)
  header <- records[[1]]
  if (header$format != "arl-recording" || !header$version %in% c(1, 2)) stop(path, ": not version 1 or 2")
  events <- records[-1]
  closed <- length(events) > 0 && events[[length(events)]]$type == "end"
  if (closed) events <- head(events, -1)
  list(header = header, events = events, closed = closed)
}

# Returns the presses that count: one row each, time in seconds.
presses <- function(recording) {
  of_type <- function(type) Filter(function(event) event$type == type, recording$events)
  taken_back <- vapply(of_type("press-retracted"), function(event) event$press, numeric(1))
  counted <- Filter(function(event) event$verdict == "accepted" && !event$press %in% taken_back,
                    of_type("key-pressed"))
  number <- function(name) vapply(counted, function(event) as.numeric(event[[name]]), numeric(1))
  data.frame(press = number("press"), time_s = (number("time_ns") - recording$header$started_ns) / 1e9,
             value = number("value"), step = number("step"))
}

if (sys.nframe() == 0) {
  write.csv(presses(read_recording(commandArgs(trailingOnly = TRUE)[1])), row.names = FALSE)
}
