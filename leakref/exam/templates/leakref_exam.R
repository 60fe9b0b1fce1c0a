# Answers the questions in this folder with a function of yours (R 3.6 or later, no package):
#
#   source("leakref_exam.R")
#   leakref_exam(my_current)
#
# where my_current(eta, p) gives a matrix with a row (cx, cy) for each of p$wavenumbers, NA where it has no number. eta is
# the cube, an array; p has dx, dy, dt, gravity, wavenumbers, window, method (and depth, surface_tension if they were
# declared), and x, y, t. A code with wavenumbers of its own returns list(velocities = , wavenumbers = ). For other
# stages pass list(extract = , window = , spectrum = , synthesize = ): window(p), of p$name and p$size; spectrum(eta, p);
# synthesize(p), of p$kx, p$ky, p$omega, p$amplitude, p$phase, p$x, p$y, p$t. What a function cannot do it says by
# stop("unsupported: why"). Stopped, it goes on where it was; to start anew remove answers.part.
leakref_exam <- function(code, folder = ".") {
  if (is.function(code)) code <- list(extract = code)
  lines <- readLines(file.path(folder, "questions.tsv"))
  head <- strsplit(lines[1], "\t")[[1]]
  if (head[1] != "leakref/exam/1" || head[3] != "raw")
    stop("questions.tsv is no examination in raw: have it written with --format raw")
  kept <- leakref_kept(folder, head[2])  # what was answered before: a line each, the id and the answer
  done <- sub("\t.*", "", kept)
  answers <- sub("^[^\t]*\t", "", kept)
  declared <- trimws(paste(readLines(file.path(folder, "declaration.json")), collapse = " "))
  keep <- function() {  # after each question: answers.json is whole at any time
    leakref_put(file.path(folder, "answers.new"), paste0('{"digest": "', head[2], '", "code": ', declared,
                ', "answers": [\n', paste(answers, collapse = ",\n"), "\n]}\n"))
    file.rename(file.path(folder, "answers.new"), file.path(folder, "answers.json"))
  }
  rows <- strsplit(lines[-(1:2)], "\t")
  begun <- proc.time()[["elapsed"]]
  asked <- 0
  for (n in seq_along(rows)) {
    id <- rows[[n]][1]
    if (id %in% done) next
    answer <- leakref_answered(code, folder, rows[[n]])
    leakref_put(file.path(folder, "answers.part"), paste0(id, "\t", answer, "\n"), "ab")
    answers <- c(answers, answer)
    keep()
    asked <- asked + 1
    left <- (proc.time()[["elapsed"]] - begun) / asked * (length(rows) - length(answers))
    cat(sprintf("%4d of %d  %-44s about %.0f s to go\n", n, length(rows), id, left))
  }
  keep()
  cat(sprintf("All %d questions are answered, in answers.json. For the marks, where leakref is installed:\n\n", length(rows)))
  cat(sprintf("    leakref exam grade %s\n\n", normalizePath(folder)))
}

leakref_put <- function(path, text, mode = "wb") {
  file <- file(path, mode)
  on.exit(close(file))
  writeChar(text, file, eos = NULL, useBytes = TRUE)
}

leakref_kept <- function(folder, digest) {
  path <- file.path(folder, "answers.part")
  text <- paste0(digest, "\n")
  if (file.exists(path)) {
    text <- sub("[^\n]*$", "", readChar(path, file.info(path)$size, useBytes = TRUE))  # a line cut off is answered again
  } else if (file.exists(file.path(folder, "answers.json"))) {
    stop("there is an answers.json that no answers.part goes with: move it away")
  }
  lines <- strsplit(text, "\n", fixed = TRUE)[[1]]
  if (length(lines) == 0 || lines[1] != digest)
    stop("answers.part answers another examination: remove it, and answers.json, to answer this one")
  leakref_put(path, text)
  lines[-1]
}

leakref_parameters <- function(cells) {  # NAME=VALUE: words, numbers, or several with commas between them
  p <- lapply(sub("^[^=]*=", "", cells), function(value) value)
  names(p) <- sub("=.*", "", cells)
  numeric <- !(names(p) %in% c("window", "method", "name"))
  p[numeric] <- lapply(p[numeric], function(value) as.numeric(strsplit(value, ",")[[1]]))
  p
}

# The arrays of a question, little-endian with the last index fastest. Refuses those of another examination.
leakref_arrays <- function(p, folder, input, should) {
  if (input == "-") return(p)
  bytes <- raw(0)
  for (name in sort(sub("^shape_", "", grep("^shape_", names(p), value = TRUE)), method = "radix")) {
    path <- file.path(folder, input, paste0(name, ".f64"))
    if (!file.exists(path)) next
    own <- readBin(path, "raw", file.info(path)$size)
    bytes <- c(bytes, own)
    values <- readBin(own, "double", length(own) / 8, endian = "little")
    shape <- p[[paste0("shape_", name)]]
    p[[name]] <- if (length(shape) > 1) aperm(array(values, rev(shape))) else values
  }
  b <- as.numeric(bytes)
  n <- length(b)
  found <- (n + sum((seq(n, 1) %% 65521) * b)) %% 65521 * 65536 + (1 + sum(b)) %% 65521  # Adler-32
  if (n == 0 || found != should)
    stop(structure(class = c("leakref_stale", "error", "condition"), list(call = NULL, message =
         paste(input, "is not of this examination: copy the whole folder again"))))
  p
}

leakref_answered <- function(code, folder, cells) {
  id <- cells[1]
  stage <- cells[2]
  found <- tryCatch({
    p <- leakref_arrays(leakref_parameters(cells[-(1:5)]), folder, cells[3], as.numeric(cells[4]))
    if (is.null(code[[stage]])) stop("unsupported: no function was given for ", stage)
    value <- if (stage %in% c("extract", "spectrum")) code[[stage]](p$eta, p) else code[[stage]](p)
    rest <- if (stage == "extract") leakref_rows(value) else {
      name <- c(spectrum = "S", synthesize = "eta", window = "w")[[stage]]
      leakref_output(file.path(folder, cells[5]), name, value)
      paste0(', "output": "', cells[5], '"')
    }
    paste0('"ok"', rest)
  }, error = function(fault) {
    if (inherits(fault, "leakref_stale")) stop(fault)
    said <- conditionMessage(fault)
    status <- if (startsWith(said, "unsupported:")) '"unsupported"' else '"error"'
    said <- gsub("[^ -~]|[\"\\\\]", " ", said)
    paste0(status, ', "message": "', said, '"')
  })
  paste0('{"id": "', id, '", "status": ', found, "}")
}

leakref_numbers <- function(values) {  # JSON has no word for infinity
  text <- sprintf("%.17g", values)
  text[is.infinite(values)] <- ifelse(values[is.infinite(values)] > 0, "1e999", "-1e999")
  paste(text, collapse = ", ")
}

leakref_rows <- function(value) {
  rest <- ""
  if (is.list(value)) {
    rest <- paste0(', "wavenumbers": [', leakref_numbers(value$wavenumbers), "]")
    value <- value$velocities
  }
  value <- if (is.matrix(value)) value else matrix(value, 1)
  rows <- apply(value, 1, function(c) if (anyNA(c)) "null" else paste0("[", leakref_numbers(c), "]"))
  paste0(rest, ', "velocities": [', paste(rows, collapse = ", "), "]")
}

leakref_output <- function(place, name, value) {  # an array that comes back, as a file
  dir.create(place, recursive = TRUE, showWarnings = FALSE)
  value <- if (is.null(dim(value))) c(value) else c(aperm(value))
  writeBin(if (is.complex(value)) c(rbind(Re(value), Im(value))) else as.numeric(value),
           file.path(place, paste0(name, ".f64")), endian = "little")
}
