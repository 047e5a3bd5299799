# Analyse presses by participant, condition and game: Rscript presses_in_lme4.R TABLES. Needs lme4.
presses <- read.csv(file.path(commandArgs(trailingOnly = TRUE)[1], "presses.csv"), na.strings = "")
counted <- subset(presses, counted & !is.na(since_shown_s) & since_shown_s > 0)
print(aggregate(value ~ participant + game, counted, mean))
if (requireNamespace("lme4", quietly = TRUE) && length(unique(counted$participant)) > 1) {
  print(summary(lme4::lmer(log(since_shown_s) ~ judgement + game + (1 | participant), counted)))
}
