# Compares your functions with the golden values in this folder (R 3.6 or later, no package but leakref_exam.R beside it):
#
#   source("leakref_exam.R"); source("leakref_check.R")
#   table <- leakref_check(list(window = my_window, dispersion = my_dispersion))
#
# where each function is that of a stage. It is handed the inputs of a vector, a list with its id, and returns a list of
# the outputs, or the one there is. A table of ids, digits that agree, and pass or FAIL is printed and returned:
# stopifnot(table$pass). What is allowed is `times` the tolerance of the set.
leakref_check <- function(stages, folder = ".", times = 1) {
  lines <- readLines(file.path(folder, "vectors.tsv"))
  if (lines[1] != "leakref/pack/1\traw") stop("vectors.tsv is no pack in raw: have it written with --format raw")
  table <- data.frame(id = character(), digits = numeric(), pass = logical(), why = character())
  for (cells in strsplit(lines[-(1:2)], "\t")) {
    if (is.null(stages[[cells[2]]])) next
    rest <- cells[-(1:6)]
    right <- startsWith(rest, "golden_")
    given <- leakref_arrays(leakref_parameters(rest[!right]), folder, cells[3], as.numeric(cells[4]))
    golden <- leakref_arrays(leakref_parameters(sub("^golden_", "", rest[right])), folder, cells[5], as.numeric(cells[6]))
    given$id <- cells[1]
    row <- tryCatch(leakref_agreement(stages[[cells[2]]](given), golden, times),
                    error = function(fault) list(digits = 0, why = conditionMessage(fault)))
    table <- rbind(table, data.frame(id = cells[1], digits = row$digits, pass = row$why == "", why = row$why))
    cat(sprintf("%-40s %5.1f  %s\n", cells[1], row$digits, if (row$why == "") "pass" else paste("FAIL ", row$why)))
  }
  if (nrow(table) == 0) stop("nothing was compared: no stage of the pack is offered")
  cat(sprintf("%d of %d vectors pass; %d are of stages that were not offered.\n", sum(table$pass), nrow(table),
              length(lines) - 2 - nrow(table)))
  invisible(table)
}

leakref_agreement <- function(found, golden, times) {  # the fewest digits of all outputs, and what fell short
  names <- sub("^allowed_", "", grep("^allowed_", names(golden), value = TRUE))
  if (!is.list(found)) {
    if (length(names) > 1) stop("this stage has ", length(names), " outputs: return a list of them")
    found <- stats::setNames(list(found), names)
  }
  digits <- 15.6
  why <- ""
  for (name in names) {
    if (is.null(found[[name]])) stop(name, " is missing")
    shape <- golden[[paste0("shape_", name)]]
    mine <- found[[name]]
    if (length(mine) != prod(shape) || (length(shape) > 1 && !identical(as.numeric(dim(mine)), shape)))
      stop(name, " has another shape than ", paste(shape, collapse = " x "))
    mine <- as.numeric(mine)
    right <- as.numeric(golden[[name]])
    allowed <- times * as.numeric(golden[[paste0("allowed_", name)]])
    off <- abs(mine - right)
    off[is.nan(mine) & is.nan(right)] <- 0
    off[is.na(off)] <- Inf
    bad <- is.na(allowed) & off > 0 | !is.na(allowed) & off > allowed
    if (any(bad)) {
      worst <- which.max(ifelse(bad, off, -1))
      why <- paste0(why, " ", name, "[", worst, "] is ", format(mine[worst], digits = 16), ", should be ",
                    format(right[worst], digits = 16), " within ", format(allowed[worst], digits = 2))
    }
    scale <- max(abs(right), 0, na.rm = TRUE)
    if (max(off) > 0 && scale > 0) digits <- min(digits, max(0, floor(-10 * log10(max(off) / scale)) / 10))
  }
  list(digits = digits, why = trimws(why))
}
