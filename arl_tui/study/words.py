"""Every word of the study's own pages that a participant reads, in English and marked for translation. The
study's texts come from its own files.
"""

from arl_tui.language import later

GO_ON = later("Press {key_enter} to go on")
READ_ON = later("Press {key_enter} to read on")
STOP = later("{key_stop} to stop")
CONSENT = later("Your consent")
CONSENT_HELP = later(
    "Answer every statement: {key_yes} yes, {key_no} no, arrow keys to move. Then press {key_enter}."
)
CONSENT_NEEDED = later("You can take part only if you agree to the statements marked with *.")
CONSENT_OPEN = later("Please answer every statement.")
DECLINE_HEADING = later("You do not want to take part")
DECLINE = later(
    "That is fine. Nothing about you is kept.\n\nPress {key_enter} to leave, {key_back} to go back."
)
STOP_HEADING = later("Stop here?")
STOP_TEXT = later(
    "You can stop at any time, without giving a reason. What you have done so far is kept. If you want it to "
    "be deleted, tell the experimenter your code: [b]{code}[/].\n\nPress {key_stop_yes} to stop, {key_no} to "
    "go on."
)
STOPPED = later("You have stopped. Thank you. Please tell the experimenter. Your code is [b]{code}[/].")
BREAK_HEADING = later("Time for a break")
BREAK_TEXT = later("Look away from the screen, and stretch. Go on when you are ready.")
BREAK_WAIT = later("You can go on in {seconds} s")
BREAK_OVER = later("The break is over: please go on when you are ready.\nPress {key_enter} to go on")
ANSWER_LIKERT = later("Press a number or use the arrow keys, then {key_enter}")
ANSWER_SCALE = later("Move the mark with the arrow keys, then press {key_enter}")
ANSWER_CHOICE = later("Press a number or use the arrow keys, then {key_enter}")
ANSWER_SEVERAL = later("Choose with {key_space} as many as apply, then press {key_enter}")
ANSWER_PRESS = later("Do what the sentence says")
ANSWER_TYPED = later("Type your answer, then press {key_enter}")
MAY_SKIP = later("You may leave this out: press {key_skip}")
ANEW = later(
    "# Once more from the beginning\n\nYour last visit ended early. It begins again now, from its first "
    "page. What you did before is kept."
)
PROGRESS = later("Question {number} of {count}")
BLOCK = later("Block {number} of {count}")
PRACTICE = later("Practice")
PART = later("Part {number} of {count}")
THANKS = later("Thank you!")
NUMBERS = later("You watched [b]{games}[/] games and pressed [b]{presses}[/] keys that counted.")
TAKEN_BACK = later("You took [b]{presses}[/] presses back.")
HOW_IT_PLAYED = later("{unit} per game at the beginning: [b]{first}[/]. At the end: [b]{last}[/].")
HOW_IT_PLAYED_IN_BLOCK = later(
    "Block {number}: {unit} per game at the beginning [b]{first}[/], at the end [b]{last}[/]."
)
ORDER = later("The conditions of your session were, in this order: {order}.")
CODE = later("Your code is [b]{code}[/]. Keep it if you may want your data to be deleted later.")
LEAVE = later("Press {key_enter} to leave")
ENDS_OF_A_LIKERT_ROW = (later("strongly disagree"), later("strongly agree"))
"""Of questionnaires that name none (`studies.lab.questions.Likert`)."""
